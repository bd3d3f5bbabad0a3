// Trunk and limbs: the fields of a body, and surfaces over them: skin, shirts, trousers, shoes, hands.
#ifndef CONTENT_PEOPLE_BODY_H
#define CONTENT_PEOPLE_BODY_H

#include "field.h"
#include "shape.h"

struct anatomy {
    struct build build;
    struct skeleton skeleton;
    struct field trunk, arm, leg, palm; // arm, leg, palm: of the left
    struct vec3 arm_axis, arm_up;       // of the left arm, at rest
    double upper_arm, whole_arm;        // lengths
};

void anatomy_make(const struct build *b, struct anatomy *out);

// A surface around the trunk, and around limbs that grow out of it.
struct garment {
    enum people_part part;
    double ease;      // off the skin
    double blend;     // over what hollows it is stretched
    double low, high; // of the trunk: heights off the hips' joint; `high`, 0 to 1: from armpit to neck, if
                      // over 1: of trousers, a waist
    bool arms, legs;  // whether limbs are covered
    bool trunk;       // whether the trunk is; else limbs alone
    double arm_from, arm_to; // shares of the arm
    double leg_to;           // share of the leg
    double sleeve;           // how wide sleeves hang, a radius
    double leg_width;        // as the sleeve, of trousers below the knee
    double flare;            // of the hem
    double folds;            // how deep
    double thickness;        // at openings; 0: none (skin)
    double skirt;            // to which share of the leg a skirt reaches
    double collar;           // height of a collar that stands
};

void body_garment(struct shape *s, const struct anatomy *a, const struct garment *g);
void body_hands(struct shape *s, const struct anatomy *a);
// sole: its thickness; shaft: height of the boot over the floor.
void body_shoes(struct shape *s, const struct anatomy *a, double sole, double shaft,
                const double sole_color[3]);
// Weights of a point of the trunk or a leg; of an arm or a leg, for which the trunk does not count.
void body_weigh(const struct anatomy *a, struct vec3 p, struct weights *w);
void body_weigh_limb(const struct anatomy *a, struct vec3 p, bool arm, struct weights *w);

#endif
