// A clip fills in an act: where hips, feet and hands are and how the trunk turns, each a few terms of the
// phase. One function makes a pose of it, with inverse kinematics for all four limbs. Lengths are of a person
// of 1.75 m, and those of arms and legs are stretched as the person's are. X is to the person's left.
#include "clips.h"

#include "base/result.h"
#include "field.h"

#include <string.h>

const struct clip people_clips[PEOPLE_CLIPS] = {
    [CLIP_SING] = {"sing", 4.8, 32, false},
    [CLIP_GUITAR] = {"guitar", 4.0, 32, false},
    [CLIP_DRUMS] = {"drums", 2.0, 32, true},
    [CLIP_DANCE_STEP] = {"dance-step", 2.0, 24, false},
    [CLIP_DANCE_BOUNCE] = {"dance-bounce", 2.0, 24, false},
    [CLIP_DANCE_SWAY] = {"dance-sway", 4.0, 24, false},
    [CLIP_CLAP] = {"clap", 2.0, 32, false},
    [CLIP_ARMS_UP] = {"arms-up", 2.0, 24, false},
    [CLIP_WALK] = {"walk", 1.1, 24, false},
    [CLIP_TALK] = {"talk", 6.0, 36, true},
};

struct hand {
    struct vec3 at;            // from the shoulder, in the chest's frame; x outwards
    struct vec3 elbow;         // towards which it points; x outwards
    struct vec3 fingers, back; // directions, x outwards; zero: as the forearm goes
    double curl, thumb;
    double shrug;
};

struct foot {
    struct vec3 at;   // of the ball, from where it rests; x outwards
    double yaw;       // outwards
    double pitch;     // heel up; below 0: toes up
    struct vec3 knee; // towards which it points; zero: forwards
};

struct act {
    struct vec3 hips, hips_turn, chest, head; // turns: forwards, to the left, to the right side
    struct hand hand[2];                      // left, right
    struct foot foot[2];
    double jaw, lids, look_up, look_left;
};

static double wave(double phase)
{
    return sin(2.0 * CONTENT_PI * phase);
}

static double cycle(double phase)
{
    return phase - floor(phase);
}

static struct quat turned(struct vec3 t)
{
    return quat_euler(t.x, t.y, t.z);
}

static struct vec3 outwards(struct vec3 v, int side)
{
    return vec3_make(side ? -v.x : v.x, v.y, v.z);
}

// ---- from an act to a pose ----

static void place_foot(struct pose *p, const struct act *a, int side)
{
    const struct vec3 *rest = p->s->rest;
    const struct foot *f = &a->foot[side];
    int o = side ? RIGHT_SIDE : 0;
    struct vec3 ball = vec3_make(rest[TOES + o].x, 0.0, rest[TOES + o].z);
    struct vec3 heel = vec3_make(rest[FOOT + o].x, 0.0, rest[FOOT + o].z - 0.05);
    struct quat yaw = quat_about(vec3_make(0, 1, 0), side ? -f->yaw : f->yaw);
    struct quat turn = quat_multiply(yaw, quat_about(vec3_make(1, 0, 0), f->pitch));
    struct vec3 to_ball = vec3_sub(ball, heel), at = outwards(f->at, side);
    // Flat, the foot stands with its ball in place; then it tilts about the ball or the heel.
    struct vec3 floor_ball = vec3_add(ball, at), floor_heel = vec3_sub(floor_ball, quat_rotate(yaw, to_ball));
    struct vec3 pivot = f->pitch >= 0.0 ? floor_ball : floor_heel, from = f->pitch >= 0.0 ? ball : heel;
    struct vec3 ankle = vec3_add(pivot, quat_rotate(turn, vec3_sub(rest[FOOT + o], from)));
    struct vec3 knee =
        vec3_length(f->knee) > 0.0 ? outwards(f->knee, side) : quat_rotate(yaw, vec3_make(0, 0.1, 1));
    pose_reach_leg(p, side, ankle, knee);
    pose_turn_end(p, FOOT + o, turn);
    p->local[TOES + o] = quat_about(vec3_make(1, 0, 0), f->pitch > 0.0 ? -f->pitch : 0.0);
}

static void place_hand(struct pose *p, const struct act *a, int side)
{
    const struct vec3 *rest = p->s->rest;
    const struct hand *h = &a->hand[side];
    int o = side ? RIGHT_SIDE : 0;
    struct quat chest = p->world[SPINE_HIGH];
    double length = vec3_length(vec3_sub(rest[HAND], rest[UPPER_ARM])) / 0.531;
    struct vec3 at = vec3_scale(outwards(h->at, side), length);
    pose_reach_arm(p, side, vec3_add(p->place[UPPER_ARM + o], quat_rotate(chest, at)),
                   quat_rotate(chest, outwards(h->elbow, side)));
    if (vec3_length(h->fingers) > 0.0) {
        struct vec3 axis = vec3_normalize(vec3_sub(rest[HAND + o], rest[UPPER_ARM + o]));
        struct vec3 up = vec3_cross(vec3_make(0, 0, 1), axis);
        up = side ? vec3_scale(up, -1.0) : up;
        pose_turn_end(p, HAND + o,
                      quat_frames(axis, up, quat_rotate(chest, outwards(h->fingers, side)),
                                  quat_rotate(chest, outwards(h->back, side))));
    }
    struct vec3 bend = vec3_make(0, 0, side ? 1 : -1);
    for (int i = 2; i < 10; i++) {
        double more = 1.0 + 0.07 * (i / 2 - 2), part = i % 2 ? 1.15 : 0.85;
        p->local[FINGERS + i + o] = quat_about(bend, h->curl * more * part);
    }
    struct vec3 axis = vec3_normalize(vec3_sub(rest[HAND], rest[UPPER_ARM]));
    struct vec3 in = vec3_normalize(vec3_add(vec3_scale(axis, -0.75), vec3_make(0, 0, -0.45)));
    in = side ? vec3_make(in.x, -in.y, -in.z) : in;
    p->local[FINGERS + o] = quat_about(in, 0.45 * h->thumb);
    p->local[FINGERS + 1 + o] = quat_about(vec3_make(-bend.x, -0.5 * bend.z, bend.z), 0.5 * h->thumb);
    struct quat *thumb = &p->local[FINGERS + 1 + o];
    double n = sqrt(thumb->x * thumb->x + thumb->y * thumb->y + thumb->z * thumb->z + thumb->w * thumb->w);
    *thumb = (struct quat){thumb->x / n, thumb->y / n, thumb->z / n, thumb->w / n};
}

static void perform(struct pose *p, const struct act *a)
{
    double legs = p->s->rest[UPPER_LEG].y / 0.925;
    p->hips = vec3_add(p->s->rest[HIPS], vec3_make(a->hips.x, a->hips.y * legs, a->hips.z));
    p->local[HIPS] = turned(a->hips_turn);
    static const double parts[3] = {0.30, 0.36, 0.34};
    for (int i = 0; i < 3; i++)
        p->local[SPINE_LOW + i] = turned(vec3_scale(a->chest, parts[i]));
    p->local[NECK] = turned(vec3_scale(a->head, 0.45));
    p->local[HEAD] = turned(vec3_scale(a->head, 0.55));
    p->local[JAW] = quat_about(vec3_make(1, 0, 0), a->jaw);
    p->local[LIDS] = quat_about(vec3_make(1, 0, 0), a->lids * 0.78 + fmax(-a->look_up, 0.0) * 0.5);
    p->local[EYE_LEFT] = p->local[EYE_RIGHT] = quat_euler(-a->look_up, a->look_left, 0.0);
    for (int side = 0; side < 2; side++) {
        double sign = side ? -1.0 : 1.0,
               lift = a->hand[side].shrug + 0.75 * fmax(a->hand[side].at.y + 0.12, 0.0);
        p->local[CLAVICLE + (side ? RIGHT_SIDE : 0)] = quat_about(vec3_make(0, 0, 1), sign * fmin(lift, 0.5));
    }
    pose_solve(p);
    for (int side = 0; side < 2; side++) {
        place_foot(p, a, side);
        place_hand(p, a, side);
    }
    pose_follow(p);
}

// ---- clips ----

static struct act standing(void)
{
    struct act a = {.hips = {0, -0.018, 0}};
    for (int side = 0; side < 2; side++) {
        a.foot[side] = (struct foot){.at = {0.02, 0, 0}, .yaw = 0.16};
        a.hand[side] =
            (struct hand){.at = {0.075, -0.505, 0.03}, .elbow = {0.35, 0, -1}, .curl = 0.35, .thumb = 0.3};
    }
    return a;
}

static struct act seated(void)
{
    struct act a = standing();
    a.hips = vec3_make(0, -0.415, -0.20);
    for (int side = 0; side < 2; side++) {
        a.foot[side].at = vec3_make(0.06, 0, 0.16);
        a.foot[side].knee = vec3_make(0.25, 1, 0.6);
    }
    return a;
}

static double blink(double phase, double at)
{
    return bump(cycle(phase - at + 0.5), 0.5, 0.022);
}

static void sing(double p, struct act *a)
{
    double sway = wave(p), beat = wave(2.0 * p);
    a->hips = vec3_make(0.030 * sway, -0.022 - 0.006 * beat, 0.01 * wave(p + 0.2));
    a->hips_turn = vec3_make(-0.02, 0.10 * wave(p + 0.05), -0.05 * sway);
    a->chest = vec3_make(-0.06 + 0.05 * wave(2.0 * p + 0.1), -0.12 * wave(p + 0.12), 0.08 * wave(p + 0.08));
    a->head = vec3_make(-0.06 - 0.10 * ramp(wave(p + 0.6), -0.2, 1.0), 0.10 * wave(p + 0.3),
                        -0.10 * wave(p + 0.15));
    a->hand[1].at = vec3_make(-0.135, 0.075 + 0.01 * beat, 0.285); // the right one at the microphone
    a->hand[1].elbow = vec3_make(0.7, -0.8, -0.2);
    a->hand[1].fingers = vec3_make(-0.75, 0.45, -0.20);
    a->hand[1].back = vec3_make(0.35, 0.1, 0.9);
    a->hand[1].curl = 1.15;
    a->hand[1].thumb = 1.0;
    double open = ramp(wave(p + 0.55), -0.6, 0.9);
    a->hand[0].at = vec3_make(mix(0.10, 0.30, open), mix(-0.36, -0.10, open), mix(0.28, 0.30, open));
    a->hand[0].elbow = vec3_make(0.6, -0.7, -0.6);
    a->hand[0].fingers = vec3_make(mix(0.1, 0.55, open), mix(0.1, 0.45, open), 0.7);
    a->hand[0].back = vec3_make(0.5, mix(0.3, -0.6, open), -0.1);
    a->hand[0].curl = mix(0.45, 0.15, open);
    a->hand[0].thumb = 0.1;
    a->jaw = 0.05 + 0.17 * ramp(wave(4.0 * p) + 0.6 * wave(3.0 * p + 0.2), -0.4, 1.1) *
                        ramp(wave(p + 0.75), -1.0, -0.3);
    a->foot[1].at = vec3_make(0.05, 0, -0.05);
    a->foot[0].at = vec3_make(0.03, 0, 0.04);
    a->foot[1].pitch = 0.22 * ramp(sway, 0.1, 1.0);
    a->lids = fmax(0.55 * ramp(wave(p + 0.6), 0.3, 0.9), blink(p, 0.12));
}

static void guitar(double p, struct act *a)
{
    double strum = wave(8.0 * p), sway = wave(p), nod = wave(4.0 * p);
    a->hips = vec3_make(0.025 * sway, -0.035 - 0.008 * nod, 0);
    a->hips_turn = vec3_make(0.03, -0.22 + 0.06 * wave(p + 0.1), -0.04 * sway);
    a->chest = vec3_make(0.10 + 0.02 * nod, 0.06 - 0.05 * wave(p + 0.2), 0.04 * sway);
    a->head = vec3_make(0.16 + 0.07 * wave(4.0 * p - 0.07), 0.24 + 0.10 * wave(p + 0.35), 0.06 * sway);
    double fret = ramp(wave(2.0 * p), -0.3, 0.3);
    a->hand[0].at = vec3_make(mix(0.22, 0.17, fret), mix(-0.23, -0.26, fret), 0.30);
    a->hand[0].elbow = vec3_make(0.45, -1, 0.1);
    a->hand[0].fingers = vec3_make(-0.35, 0.55, -0.55);
    a->hand[0].back = vec3_make(0.5, 0.2, 0.75);
    a->hand[0].curl = 0.95 + 0.08 * wave(4.0 * p);
    a->hand[0].thumb = 0.8;
    a->hand[1].at = vec3_make(-0.085 + 0.006 * strum, -0.40 + 0.030 * strum, 0.235 + 0.006 * strum);
    a->hand[1].elbow = vec3_make(0.9, 0.1, -0.5);
    a->hand[1].fingers = vec3_make(-0.80, -0.35 + 0.12 * strum, 0.15);
    a->hand[1].back = vec3_make(0.1, 0.25, 0.9);
    a->hand[1].curl = 0.75;
    a->hand[1].thumb = 1.0;
    a->foot[0].at = vec3_make(0.08, 0, 0.10);
    a->foot[1].at = vec3_make(0.07, 0, -0.06);
    a->foot[0].pitch = -0.16 * ramp(nod, 0.0, 1.0);
    a->look_up = -0.12;
    a->lids = 0.25 + 0.7 * blink(p, 0.4);
}

static double hit(double phase) // the height of a stick: a slow rise, a fast fall
{
    double t = cycle(phase);
    return t < 0.62 ? ramp(t, 0.0, 0.62) : 1.0 - pow((t - 0.62) / 0.38, 1.8);
}

static void drums(double p, struct act *a)
{
    *a = seated();
    double right = hit(4.0 * p), left = hit(2.0 * p + 0.5), nod = wave(4.0 * p);
    a->hips_turn = vec3_make(0.02, 0.03 * wave(2.0 * p), 0);
    a->chest = vec3_make(0.16 + 0.03 * nod, 0.10 * wave(2.0 * p + 0.1), 0.05 * wave(2.0 * p));
    a->head = vec3_make(0.02 + 0.10 * wave(4.0 * p - 0.08), 0.20 * wave(p), 0.06 * wave(2.0 * p + 0.1));
    a->hand[0].at = vec3_make(-0.06, -0.33 + 0.17 * left, 0.33 - 0.04 * left);
    a->hand[0].elbow = vec3_make(0.9, -0.6, -0.5);
    a->hand[0].fingers = vec3_make(-0.35, -0.25 + 0.5 * left, 0.8);
    a->hand[0].back = vec3_make(0.35, 0.9, 0.3);
    a->hand[1].at = vec3_make(0.02 + 0.05 * wave(p), -0.23 + 0.13 * right, 0.37 - 0.03 * right);
    a->hand[1].elbow = vec3_make(0.9, -0.5, -0.4);
    a->hand[1].fingers = vec3_make(-0.25, -0.25 + 0.55 * right, 0.8);
    a->hand[1].back = vec3_make(0.35, 0.9, 0.3);
    for (int side = 0; side < 2; side++) {
        a->hand[side].curl = 1.25;
        a->hand[side].thumb = 1.0;
        a->foot[side].at = vec3_make(0.12, 0, 0.20);
        a->foot[side].pitch = -0.05;
    }
    a->foot[1].pitch = 0.30 * hit(2.0 * p);
    a->lids = blink(p, 0.3);
    a->jaw = 0.03;
}

// From 0 to 1 while the phase is in a quarter.
static double quarter(double p, int which)
{
    return ramp(4.0 * p - which, 0.08, 0.85);
}

static void dance_step(double p, struct act *a)
{
    double left = 0.30 * (quarter(p, 0) - quarter(p, 3)), right = 0.30 * (quarter(p, 1) - quarter(p, 2)),
           beat = wave(4.0 * p + 0.25);
    a->foot[0].at.x += left - 0.15;
    a->foot[1].at.x += 0.15 - right;
    for (int side = 0; side < 2; side++) {
        int out = side ? 2 : 0, in = side ? 1 : 3;
        double t = 4.0 * p;
        double lift = 0.0;
        for (int k = 0; k < 2; k++) {
            double u = (t - (k ? in : out) - 0.08) / 0.77;
            lift += u > 0.0 && u < 1.0 ? sin(CONTENT_PI * u) : 0.0;
        }
        a->foot[side].at.y = 0.055 * lift;
        a->foot[side].pitch = 0.38 * lift;
    }
    double center = 0.5 * (left + right) - 0.15, shift = wave(p - 0.14);
    a->hips = vec3_make(center + 0.055 * shift, -0.050 + 0.018 * beat, -0.01);
    a->hips_turn = vec3_make(0.04, 0.16 * wave(p - 0.1), -0.09 * wave(p - 0.05));
    a->chest = vec3_make(0.06 + 0.05 * wave(4.0 * p + 0.1), -0.30 * wave(p - 0.06), 0.13 * wave(p - 0.12));
    a->head = vec3_make(0.05 * wave(4.0 * p), 0.16 * wave(p - 0.02), -0.08 * wave(p - 0.2));
    for (int side = 0; side < 2; side++) {
        double s = side ? -1.0 : 1.0, swing = wave(p + 0.02) * s, pump = wave(2.0 * p + 0.1 * side);
        a->hand[side].at = vec3_make(0.13 + 0.07 * swing, -0.25 + 0.06 * pump, 0.24 - 0.10 * swing);
        a->hand[side].elbow = vec3_make(0.75, -0.5, -0.8);
        a->hand[side].curl = 0.85 + 0.2 * pump;
        a->hand[side].thumb = 0.7;
        a->hand[side].shrug = 0.06 + 0.06 * wave(2.0 * p + 0.3 * side);
    }
    a->lids = blink(p, 0.6);
}

static void dance_bounce(double p, struct act *a)
{
    double beat = 0.5 - 0.5 * cos(8.0 * CONTENT_PI * p), side_shift = wave(2.0 * p);
    a->hips = vec3_make(0.035 * wave(p), -0.095 + 0.060 * beat, -0.02);
    a->hips_turn = vec3_make(0.10 - 0.04 * beat, 0.12 * wave(p + 0.05), -0.04 * wave(p));
    a->chest = vec3_make(0.12 - 0.10 * beat, -0.26 * wave(p + 0.05), 0.05 * side_shift);
    a->head = vec3_make(-0.02 + 0.16 * (beat - 0.5), 0.18 * wave(p + 0.1), 0.05 * wave(2.0 * p));
    for (int side = 0; side < 2; side++) {
        double up = ramp(wave(p + (side ? 0.5 : 0.0)), -0.45, 0.45);
        a->hand[side].at =
            vec3_make(mix(0.11, 0.12, up), mix(-0.22, 0.36, up) + 0.05 * (beat - 0.5), mix(0.27, 0.17, up));
        a->hand[side].elbow = vec3_make(0.9, mix(-0.7, -0.1, up), mix(-0.6, 0.2, up));
        a->hand[side].curl = mix(1.2, 0.9, up);
        a->hand[side].thumb = 0.9;
        a->foot[side].at = vec3_make(0.10, 0, side ? -0.03 : 0.03);
        a->foot[side].yaw = 0.28;
        a->foot[side].pitch = 0.30 * ramp(wave(p + (side ? 0.0 : 0.5)), 0.1, 1.0);
    }
    a->jaw = 0.05 + 0.05 * beat;
    a->lids = blink(p, 0.2);
}

static void dance_sway(double p, struct act *a)
{
    a->hips =
        vec3_make(0.075 * wave(p), -0.045 + 0.014 * cos(8.0 * CONTENT_PI * p - 0.6), 0.022 * wave(2.0 * p));
    a->hips_turn = vec3_make(0.02, 0.14 * wave(p + 0.2), -0.13 * wave(p));
    a->chest = vec3_make(-0.08 + 0.04 * wave(2.0 * p + 0.3), -0.10 * wave(p + 0.25), 0.20 * wave(p + 0.06));
    a->head = vec3_make(-0.06 + 0.05 * wave(2.0 * p), 0.20 * wave(p + 0.40), -0.16 * wave(p + 0.10));
    for (int side = 0; side < 2; side++) {
        double s = side ? 0.5 : 0.0, roll = wave(p + 0.12 + s), soft = wave(2.0 * p + 0.3 * side);
        a->hand[side].at = vec3_make(0.08 + 0.10 * roll, 0.34 + 0.06 * soft - (side ? 0.05 : 0.0),
                                     0.10 + 0.08 * wave(p + 0.37 + s));
        a->hand[side].elbow = vec3_make(1.0, 0.05, 0.25);
        a->hand[side].fingers = vec3_make(-0.25 + 0.5 * roll, 0.85, 0.15);
        a->hand[side].back = vec3_make(0.5, 0.2, -0.8);
        a->hand[side].curl = 0.35 + 0.15 * soft;
        a->hand[side].thumb = 0.2;
        a->foot[side].at = vec3_make(0.055, 0, side ? -0.03 : 0.03);
        a->foot[side].pitch = 0.42 * ramp(wave(p) * (side ? 1.0 : -1.0), 0.0, 1.0);
        a->foot[side].yaw = 0.22;
    }
    a->lids = fmax(0.45 + 0.35 * wave(p + 0.2), blink(p, 0.7));
}

static void clap(double p, struct act *a)
{
    double beat = cycle(4.0 * p),
           apart = beat < 0.55 ? ramp(beat, 0.02, 0.55) : 1.0 - pow((beat - 0.55) / 0.45, 1.6);
    a->hips = vec3_make(0.022 * wave(p), -0.020 - 0.006 * wave(4.0 * p), 0);
    a->hips_turn = vec3_make(0.0, 0.05 * wave(p + 0.1), -0.035 * wave(p));
    a->chest = vec3_make(-0.02 + 0.02 * wave(4.0 * p), -0.06 * wave(p + 0.1), 0.05 * wave(p));
    a->head = vec3_make(-0.04 + 0.03 * wave(2.0 * p), 0.12 * wave(p + 0.2), 0.05 * wave(p + 0.1));
    for (int side = 0; side < 2; side++) {
        a->hand[side].at = vec3_make(-0.148 + 0.12 * apart, -0.05 + 0.02 * apart + (side ? 0.006 : -0.012),
                                     0.315 + 0.01 * apart);
        a->hand[side].elbow = vec3_make(0.8, -0.8, -0.1);
        a->hand[side].fingers = vec3_make(-0.08 + 0.25 * apart, 0.75, 0.55);
        a->hand[side].back = vec3_make(0.9, 0.1, -0.1);
        a->hand[side].curl = 0.12;
        a->hand[side].thumb = 0.1;
    }
    a->foot[1].at = vec3_make(0.03, 0, -0.04);
    a->foot[0].pitch = 0.15 * ramp(-wave(p), 0.2, 1.0);
    a->jaw = 0.02;
    a->lids = blink(p, 0.45);
}

static void arms_up(double p, struct act *a)
{
    double beat = 0.5 - 0.5 * cos(8.0 * CONTENT_PI * p);
    a->hips = vec3_make(0.018 * wave(p), -0.055 + 0.065 * beat, -0.01);
    a->hips_turn = vec3_make(0.04 - 0.04 * beat, 0.05 * wave(p), -0.02 * wave(p));
    a->chest = vec3_make(-0.10 + 0.08 * (0.5 - beat), 0.08 * wave(p), 0.07 * wave(p));
    a->head = vec3_make(-0.20 + 0.06 * beat, 0.12 * wave(p + 0.1), 0.04 * wave(p));
    for (int side = 0; side < 2; side++) {
        double shake = wave(2.0 * p + 0.1 * side + 0.1);
        a->hand[side].at =
            vec3_make(0.15 + 0.045 * shake, 0.43 + 0.035 * wave(4.0 * p - 0.3), 0.06 + 0.03 * shake);
        a->hand[side].elbow = vec3_make(1.0, 0.0, 0.3);
        a->hand[side].fingers = vec3_make(0.25 + 0.25 * shake, 0.9, 0.05);
        a->hand[side].back = vec3_make(0.15, 0.0, -1.0);
        a->hand[side].curl = side ? 0.10 : 0.16;
        a->foot[side].at = vec3_make(0.045, 0, side ? 0.02 : -0.02);
        a->foot[side].pitch = 0.30 * beat;
    }
    a->jaw = 0.08 + 0.09 * beat;
    a->lids = blink(p, 0.3) * 0.9;
    a->look_up = 0.12;
}

// ---- walking ----

#define STRIDE 1.06 // of both steps, of legs as they are
#define STANCE 0.6

static double legs_of(const struct skeleton *s)
{
    return s->rest[UPPER_LEG].y / 0.925;
}

double people_walk_speed(const struct skeleton *s)
{
    return STRIDE * legs_of(s) / people_clips[CLIP_WALK].seconds * s->height;
}

static struct foot step(double phase, double stride)
{
    double t = cycle(phase), front = 0.40 * stride - 0.09;
    struct foot f = {.at = {-0.045, 0, front - stride * t}, .yaw = 0.09};
    if (t < STANCE) {
        f.pitch =
            t < 0.09 ? -0.30 * (1.0 - t / 0.09) : 0.78 * pow(fmax(t - 0.30, 0.0) / (STANCE - 0.30), 1.6);
        return f;
    }
    double u = (t - STANCE) / (1.0 - STANCE), slope = -stride * (1.0 - STANCE);
    // Hermite: leaves and lands with the speed of the ground.
    double h00 = (1 + 2 * u) * (1 - u) * (1 - u), h10 = u * (1 - u) * (1 - u), h01 = u * u * (3 - 2 * u),
           h11 = u * u * (u - 1);
    f.at.z = h00 * (front - stride * STANCE) + h10 * slope + h01 * front + h11 * slope;
    f.at.y = 0.050 * sin(CONTENT_PI * u) * (1.0 - 0.35 * u);
    f.pitch = mix(0.78, -0.30, ramp(u, 0.05, 0.95));
    if (f.pitch < 0.0)
        f.at.y = fmax(f.at.y, 0.0);
    return f;
}

static void walk(const struct skeleton *s, double p, struct act *a)
{
    double stride = STRIDE * legs_of(s);
    a->foot[0] = step(p, stride);
    a->foot[1] = step(p + 0.5, stride);
    double forward = cos(2.0 * CONTENT_PI * (p - 0.02)); // of the left foot
    a->hips = vec3_make(0.018 * wave(p - 0.02), -0.046 - 0.016 * cos(4.0 * CONTENT_PI * (p + 0.02)), -0.01);
    a->hips_turn = vec3_make(0.035, -0.11 * forward, -0.045 * wave(p + 0.02));
    a->chest = vec3_make(0.02 + 0.012 * wave(2.0 * p), 0.22 * forward, 0.055 * wave(p + 0.03));
    a->head = vec3_make(-0.03 + 0.012 * wave(2.0 * p + 0.2), -0.10 * forward, -0.012 * wave(p));
    for (int side = 0; side < 2; side++) {
        double swing =
            cos(2.0 * CONTENT_PI * (p + (side ? 0.46 : -0.04))) * (side ? 0.92 : 1.0); // as the foot below
        a->hand[side].at =
            vec3_make(0.075 + 0.01 * swing, -0.485 + 0.035 * swing * swing, 0.03 - 0.17 * swing);
        a->hand[side].elbow = vec3_make(0.30, 0.0, -1);
        a->hand[side].curl = 0.5;
        a->hand[side].thumb = 0.5;
    }
    a->lids = blink(p, 0.15) * 0.0;
}

static void talk(double p, struct act *a)
{
    *a = seated();
    double lean = wave(p);
    a->hips_turn = vec3_make(-0.10, 0.04 * wave(p + 0.2), 0);
    a->chest = vec3_make(0.12 + 0.05 * lean, 0.08 * wave(p + 0.1), 0.03 * wave(2.0 * p));
    a->head = vec3_make(0.0 + 0.06 * wave(3.0 * p + 0.2), 0.22 * wave(p + 0.35), 0.06 * wave(2.0 * p + 0.4));
    double say = ramp(wave(p + 0.1), -0.35, 0.5), stress = 0.5 + 0.5 * wave(3.0 * p);
    a->hand[0].at =
        vec3_make(mix(-0.02, 0.07, say), mix(-0.425, -0.27, say) + 0.03 * stress * say, mix(0.27, 0.33, say));
    a->hand[0].elbow = vec3_make(0.7, -0.6, -0.7);
    a->hand[0].fingers = vec3_make(mix(-0.35, 0.10, say), mix(-0.15, 0.30, say), 0.85);
    a->hand[0].back = vec3_make(mix(0.25, 0.75, say), mix(0.9, -0.10, say), mix(0.2, 0.0, say));
    a->hand[0].curl = mix(0.45, 0.25, say);
    a->hand[1].at = vec3_make(-0.01, -0.43 + 0.05 * (1.0 - say) * stress, 0.27);
    a->hand[1].elbow = vec3_make(0.7, -0.5, -0.7);
    a->hand[1].fingers = vec3_make(-0.35, -0.15, 0.85);
    a->hand[1].back = vec3_make(0.25, 0.9, 0.2);
    a->hand[1].curl = 0.45;
    a->foot[0].at = vec3_make(0.05, 0, 0.24);
    a->foot[1].at = vec3_make(0.05, 0, 0.13);
    a->foot[1].pitch = 0.1;
    a->jaw = 0.015 + 0.10 * ramp(wave(9.0 * p) + 0.7 * wave(7.0 * p + 0.3), -0.5, 1.2) *
                         ramp(wave(p + 0.1), -0.8, 0.0);
    a->lids = fmax(blink(p, 0.2), blink(p, 0.72));
    a->look_left = -0.12 * wave(p + 0.35);
}

void people_pose(const struct skeleton *s, enum people_clip clip, double phase, struct pose *p)
{
    static void (*const acts[PEOPLE_CLIPS])(double, struct act *) = {[CLIP_SING] = sing,
                                                                     [CLIP_GUITAR] = guitar,
                                                                     [CLIP_DRUMS] = drums,
                                                                     [CLIP_DANCE_STEP] = dance_step,
                                                                     [CLIP_DANCE_BOUNCE] = dance_bounce,
                                                                     [CLIP_DANCE_SWAY] = dance_sway,
                                                                     [CLIP_CLAP] = clap,
                                                                     [CLIP_ARMS_UP] = arms_up,
                                                                     [CLIP_TALK] = talk};
    struct act a = standing();
    double t = cycle(phase);
    if (clip == CLIP_WALK)
        walk(s, t, &a);
    else
        acts[clip](t, &a);
    pose_init(p, s);
    perform(p, &a);
}
