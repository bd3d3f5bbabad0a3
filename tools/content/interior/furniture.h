// A piece of furniture under construction: hard parts by material, soft parts and lights, below one node.
#ifndef CONTENT_FURNITURE_H
#define CONTENT_FURNITURE_H

#include "look.h"
#include "soft.h"
#include "solid.h"

#define QUARTER (0.5 * CONTENT_PI) // turn

struct furniture {
    struct glb *g;
    struct looks *looks;
    const char *name;
    int node;
    struct solid parts[LOOK_COUNT];
    struct {
        uint64_t hash; // of the cage and its look
        int mesh;
    } meshes[16]; // so far: equal cages are stored once
    int mesh_count;
};

void furniture_begin(struct furniture *p, struct glb *g, struct looks *looks, const char *name, int node);
// Writes the hard parts: one mesh a material.
void furniture_end(struct furniture *p);

// The hard part of a material. What glows is a light, all of the piece together.
struct solid *furniture_part(struct furniture *p, enum look look);
// A soft part; takes the cage. Equal ones of one look share their mesh.
void furniture_soft(struct furniture *p, const char *name, struct cage *cage, enum look look,
                    struct place at);
// A light component that shines along the place's -Z: its fields, without color and strength set.
cJSON *furniture_light(struct furniture *p, const char *component, struct place at, const double color[3]);
// A spot of KHR_lights_punctual, in W/sr.
void furniture_spot(struct furniture *p, struct place at, const double color[3], double intensity,
                    double inner, double outer);

// A place whose -Z is down.
static inline struct place place_down(double x, double y, double z)
{
    return place_turn(place_at(x, y, z), 'x', -QUARTER);
}

// A box with x, z in its middle and y at its bottom.
static inline void block(struct solid *s, double x, double y, double z, double w, double h, double d,
                         double rounding)
{
    solid_box(s, place_at(x, y + 0.5 * h, z), w, h, d, rounding);
}

// A rod between two points.
static inline void rod(struct solid *s, double x0, double y0, double z0, double x1, double y1, double z1,
                       double thick, double thin)
{
    solid_rod(s, place_at(0, 0, 0), vec3_make(x0, y0, z0), vec3_make(x1, y1, z1), thick, thin);
}

// A slab of w by d with rounded corners, lying at y.
void slab(struct solid *s, double x, double y, double z, double w, double h, double d, double corner);
// A ring of tube in XZ at y.
void ring(struct solid *s, double x, double y, double z, double radius, double thick);
// A picture that fills a rectangle of w by h in XY, seen from +Z.
void picture_plane(struct solid *s, struct place p, double w, double h);

// Colours of light: incandescent, warm white, neutral.
extern const double light_warm[3], light_soft[3], light_neutral[3];

#endif
