// The skeleton that all bodies share, and poses of it.
//
// All joints rest unrotated, so a joint's rotation in the world is the one from rest, and inverse bind
// matrices are translations. People face +Z, their left is +X; they rest with straight legs and arms 40
// degrees below the horizontal. Joints named "half" turn half as far as the one after them: the skin near an
// elbow, a knee, a hip or a shoulder follows them and keeps its volume. "twist" joints take half the turn of
// what is below along a limb.
#ifndef CONTENT_PEOPLE_SKELETON_H
#define CONTENT_PEOPLE_SKELETON_H

#include "../vec.h"

enum people_joint {
    HIPS,
    SPINE_LOW,
    SPINE_MIDDLE,
    SPINE_HIGH,
    NECK,
    HEAD,
    JAW,
    LIDS,
    EYE_LEFT,
    EYE_RIGHT,
    // One side; RIGHT_SIDE later the same of the other.
    CLAVICLE,
    SHOULDER_HALF,
    UPPER_ARM,
    ELBOW_HALF,
    LOWER_ARM,
    LOWER_ARM_TWIST,
    HAND,
    FINGERS, // thumb, index, middle, ring, little; two joints each
    FINGERS_END = FINGERS + 10,
    HIP_HALF = FINGERS_END,
    UPPER_LEG,
    KNEE_HALF,
    LOWER_LEG,
    FOOT,
    TOES,
    SIDE_END,
    RIGHT_SIDE = SIDE_END - CLAVICLE,
    PEOPLE_JOINTS = SIDE_END + RIGHT_SIDE
};

// Factors on a person of 1.75 m, 1 each, except weight (-1 thin to 1 heavy), muscle and female (0 to 1).
struct build {
    double height, legs, arms, shoulders, hips, head;
    double weight, muscle, female;
};

struct skeleton {
    int parent[PEOPLE_JOINTS];
    struct vec3 rest[PEOPLE_JOINTS]; // in the world, before `height`
    double height;
};

void skeleton_make(const struct build *b, struct skeleton *out);
// Writes a joint's name, "upper-arm-left" or like, into `out`.
void skeleton_name(int joint, char out[32]);
// The joint on the other side of the body.
int skeleton_mirror(int joint);

// ---- poses ----

struct quat {
    double x, y, z, w;
};

struct quat quat_identity(void);
struct quat quat_about(struct vec3 axis, double angle);  // of unit length
struct quat quat_multiply(struct quat a, struct quat b); // b first
struct quat quat_conjugate(struct quat q);
struct vec3 quat_rotate(struct quat q, struct vec3 v);
// The part `t` of the way from no rotation.
struct quat quat_part(struct quat q, double t);
// The rotation that takes unit vectors `from`, `from_side` to `to`, `to_side`; sides are made perpendicular.
struct quat quat_frames(struct vec3 from, struct vec3 from_side, struct vec3 to, struct vec3 to_side);
// The part of q that turns about `axis`.
struct quat quat_twist(struct quat q, struct vec3 axis);
// About X, then Y, then Z.
struct quat quat_euler(double x, double y, double z);

// A skeleton at work. Rotations are relative to the parent; the world's follow from pose_solve.
struct pose {
    const struct skeleton *s;
    struct vec3 hips; // where, before `height`
    struct quat local[PEOPLE_JOINTS];
    struct vec3 place[PEOPLE_JOINTS]; // of joints in the world, before `height`
    struct quat world[PEOPLE_JOINTS];
};

void pose_init(struct pose *p, const struct skeleton *s);
// Where joints are, from the root to the last.
void pose_solve(struct pose *p);
// Bends a limb so that its end is at `target`, in the world, or as near as it reaches; the middle points
// towards `pole`. side: 0 left, 1 right. pose_solve must have run; what hangs on the limb needs another.
void pose_reach_arm(struct pose *p, int side, struct vec3 target, struct vec3 pole);
void pose_reach_leg(struct pose *p, int side, struct vec3 target, struct vec3 pole);
// Turns a hand or a foot to a rotation in the world.
void pose_turn_end(struct pose *p, int joint, struct quat world);
// Sets joints named half and twist by what they follow. Last of all.
void pose_follow(struct pose *p);

#endif
