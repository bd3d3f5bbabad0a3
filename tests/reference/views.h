// Ways to look at a scene on a stage, and how two pictures of what a pixel shows are compared.
#ifndef NG_TESTS_REFERENCE_VIEWS_H
#define NG_TESTS_REFERENCE_VIEWS_H

#include "scene.h"

struct ng_stage;

// Pixels whose neighbours show the same thing: there, edges and filters do not matter.
bool view_is_inside(const uint32_t *ids, int width, int height, int x, int y);
// Mean difference over the pixels inside of things, relative to the layer's mean.
double view_difference(const float *a, const float *b, const uint32_t *ids, uint32_t channels, int width,
                       int height);

// Turns what has a normal map into its mirror image.
void view_mirror_normal_maps(struct ng_stage *stage);
// Normals that contradict their triangles everywhere.
void view_turn_normals(struct ng_stage *stage);
void view_look_in_parallel(struct ng_stage *stage);
// The camera behind every mirror that there is: its own scale, and a parent that also shears.
#define VIEW_CAMERAS 4
extern void (*const view_cameras[VIEW_CAMERAS])(struct ng_stage *);

#endif
