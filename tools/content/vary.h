// What may vary in a scene: nodes with a variation component (engine/components/variation.h).
#ifndef CONTENT_VARY_H
#define CONTENT_VARY_H

#include "glb.h"

struct vary {
    const char *name, *field, *kind; // kind: "range", "turn", ...
    int node, material;              // the target: index + 1, one of them
    double min[4], max[4];
    double look_min[3], look_max[3]; // cameras
    const double (*choices)[4];      // choices
    int choice_count;
};

// Adds a node below `parent` (index + 1).
void vary_add(struct glb *g, int parent, const struct vary *v);

#endif
