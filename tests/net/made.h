// Networks and inputs made of random numbers, the executor run on them, and the same program run as its
// definition reads: whole values, one operation after another, in double precision.
#ifndef NG_TESTS_NET_MADE_H
#define NG_TESTS_NET_MADE_H

#include "lightformer/net/net.h"
#include "lightformer/net/program_internal.h"

#define MADE_LIGHTS 9

// Writes a network. `weights`: "name N K" for a linear, "name N K 3" for a convolution, separated by commas.
void made_write(const char *path, const char *program, const char *weights);
// A network with most operations, for made_write.
extern const char *const made_program, *const made_weights;
// Makes the checksum of a file's bytes right again, so that what is behind it is tried. False: it has no
// place for one.
bool made_seal(unsigned char *file, size_t size);
#define MADE_HASH_AT (8 + sizeof "{\"__metadata__\":{\"hash\":\"" - 1)
// Writes and loads it.
struct lf_net *made_net(const char *program, const char *weights);

struct made_scene {
    uint32_t width, height, lights;
    uint32_t vpls[MADE_LIGHTS], texels[MADE_LIGHTS];
    struct lf_net_values frame, light[MADE_LIGHTS]; // owned
};

void made_scene_init(struct made_scene *s, uint32_t width, uint32_t height, uint32_t lights, uint64_t seed);
void made_scene_finish(struct made_scene *s);

struct made_picture {
    float *of[3]; // unshadowed, direct, indirect: [3][height][width]
    size_t count; // floats of each
};
void made_picture_finish(struct made_picture *p);

// Encodes all lights and gathers. `again`: encodes the views twice, gathers twice.
struct made_picture made_run(const struct lf_net *net, const struct made_scene *s, enum lf_net_kernel kernel,
                             uint32_t threads, bool again);
extern bool made_compact; // the next runs are (struct lf_net_executor_params)
// By definition. `program` as the file has it.
struct made_picture made_naive(const char *program, const char *weights, const struct made_scene *s);

// Sum of squared differences over sum of squares of b, the worst of the three pictures.
double made_difference(const struct made_picture *a, const struct made_picture *b);

#endif
