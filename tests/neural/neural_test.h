// A small room, lights of several types, and the method "neural" in renderers of it.
#ifndef NG_TESTS_NEURAL_TEST_H
#define NG_TESTS_NEURAL_TEST_H

#include "reference/scene.h"

#include "gpu/gpu_test.h"
#include "lightformer/neural/neural.h"
#include "render/renderer.h"

enum { PARTS = 3 }; // unshadowed, direct, indirect

// A renderer with the method.
struct method {
    struct ng_renderer *renderer;
    struct lf_neural *neural;
};

struct room {
    struct scene scene;
    struct ng_gpu *gpu;
    char weights[256];
    uint32_t width, height;
    ng_entity box, ball, white, red; // of which the first two are meshes, the others materials
    ng_entity point, panel, spot;    // lights
};

// A room closed but for its front, 4 metres wide, with a quad and a sphere in it; lights as asked for.
enum { POINT = 1, PANEL = 2, SPOT = 4 };
void room_open(struct room *room, unsigned lights);
void room_close(struct room *room);
ng_entity room_add_point(struct room *room, const float position[3], float intensity);

void method_open(const struct room *room, const struct lf_neural_params *params, struct method *out);
void method_close(struct method *m);

// Extracts the world and draws it. Expects success.
void room_draw(struct room *room, struct method *m);
// Draws what was extracted last; what that returns.
ng_result room_draw_again(const struct room *room, struct method *m);
// A layer of the last frame: [height][width][3], to free.
float *room_layer(const struct room *room, struct method *m, const char *name);
// Whether all parts of two renderers' last frames are the same bytes; tells the first that is not.
void assert_same_picture(const struct room *room, struct method *a, struct method *b, const char *after);

// Moves an entity by an offset.
void room_move(struct room *room, ng_entity e, float x, float y, float z);
void room_set(struct room *room, ng_entity e, const char *field, float value);
void room_switch(struct room *room, ng_entity light, const char *field, bool on);

#endif
