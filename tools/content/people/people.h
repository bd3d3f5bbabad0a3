// People: bodies that share a skeleton, and clips for them, written into scenes.
//
//     struct people p;
//     people_init(&p, &glb);
//     struct person singer;
//     people_add(&p, &(struct people_place){.name = "singer", .body = PEOPLE_BOB, ...}, &singer);
//     people_play(&p, &singer, CLIP_SING, "singer", 0.25);
//
// Meshes are quantized (KHR_mesh_quantization); people of one body share all of it. In other clothes they
// share all but materials.
#ifndef CONTENT_PEOPLE_H
#define CONTENT_PEOPLE_H

#include "../glb.h"
#include "clips.h"
#include "shape.h"

enum people_body {
    PEOPLE_JACKET, // a lean man, parted hair, leather jacket, jeans
    PEOPLE_BOB,    // a woman, a bob, shirt and skirt
    PEOPLE_BEARD,  // a heavy man, bald, full beard, checked shirt
    PEOPLE_LONG,   // a tall woman, long hair, leather trousers
    PEOPLE_CURLS,  // a young man, curls, hooded sweater
    PEOPLE_BUN,    // an older woman, grey bun, long cardigan
    PEOPLE_TALL,   // a tall, thin man, long hair, stubble, T-shirt
    PEOPLE_TAIL,   // a short, athletic woman, a tail of hair, top without sleeves
    PEOPLE_BODIES
};

extern const char *const people_body_names[PEOPLE_BODIES];

// The body's skin, clothes and so on, in metres at rest, and its skeleton. False when out of memory.
bool people_shape(enum people_body body, struct shape *shape, struct skeleton *skeleton);

// Base colours instead of a body's own; negative red: its own.
struct people_colors {
    double skin[3], hair[3], top[3], bottom[3], shoes[3];
};

struct people_written {
    enum people_body body;
    struct people_colors colors;
    int mesh;
};

#define PEOPLE_WRITTEN 64
struct people {
    struct glb *g;
    struct skeleton skeletons[PEOPLE_BODIES];
    struct {
        bool made;
        int inverse_bind;
        struct {
            int position, normal, uv, color, joints, weights, indices; // accessors; indices -1: no such part
        } parts[PEOPLE_PARTS];
    } bodies[PEOPLE_BODIES];
    struct people_written written[PEOPLE_WRITTEN];
    int written_count;
    int cloth, leather, denim, strands; // textures, index + 1
};

void people_init(struct people *p, struct glb *g);

struct people_place {
    const char *name;
    enum people_body body;
    const struct people_colors *colors; // null: the body's own
    int parent;                         // node, index + 1
    struct vec3 at;
    double turn; // about Y, radians
};

struct person {
    enum people_body body;
    int root; // node that places the person
    int nodes[PEOPLE_JOINTS];
};

void people_add(struct people *p, const struct people_place *place, struct person *out);
// Writes a clip as an animation, begun at `phase` (0 to 1) of it. Returns the animation.
int people_play(struct people *p, const struct person *who, enum people_clip clip, const char *name,
                double phase);

// people/people.glb: all bodies in a row, each with a clip.
NG_NODISCARD ng_result people_build(struct bytes *out);

#endif
