// Skinned meshes under construction: vertices with weights, and quads, in parts of one material each.
#ifndef CONTENT_PEOPLE_SHAPE_H
#define CONTENT_PEOPLE_SHAPE_H

#include "base/array.h"
#include "skeleton.h"

#include <stdbool.h>
#include <stdint.h>

enum people_part { PART_SKIN, PART_EYES, PART_HAIR, PART_TOP, PART_BOTTOM, PART_SHOES, PEOPLE_PARTS };

struct weights {
    double of[PEOPLE_JOINTS];
};

struct shape_vertex {
    struct vec3 place, normal;
    double uv[2];
    double color[3]; // times the material's base colour
    uint8_t joints[4];
    double weights[4]; // they sum to 1
};

struct shape_part {
    NG_ARRAY(struct shape_vertex) vertices;
    NG_ARRAY(uint32_t) triangles;
};

struct shape {
    struct shape_part parts[PEOPLE_PARTS];
    bool failed;
};

void shape_finish(struct shape *s);

// A vertex of white; the four largest weights are kept. Returns its index.
uint32_t shape_vertex(struct shape *s, enum people_part part, struct vec3 place, const double uv[2],
                      const struct weights *w);
struct shape_vertex *shape_at(struct shape *s, enum people_part part, uint32_t index);
// Counter-clockwise from outside; `flip`: clockwise. Two points may be one: a triangle.
void shape_quad(struct shape *s, enum people_part part, uint32_t a, uint32_t b, uint32_t c, uint32_t d,
                bool flip);
// Moves vertices near a place, and their weights, towards the mean of their neighbours, `steps` times.
void shape_relax(struct shape *s, enum people_part part, struct vec3 at, double radius, int steps);
// Drops vertices that no face has.
void shape_prune(struct shape *s);
// Normals from the faces around, weighted by angle, of vertices that have none yet.
void shape_normals(struct shape *s);

#endif
