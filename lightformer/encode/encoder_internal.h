// What the files of the encoder share.
//
// Every part of an encoding has a key: a hash of all that the part is made from. A pass is declared where the
// key differs from that of the last result, and leaves its key behind when it has succeeded.
#ifndef LF_ENCODE_ENCODER_INTERNAL_H
#define LF_ENCODE_ENCODER_INTERNAL_H

#include "base/array.h"
#include "lightformer/encode/encoder.h"
#include "render/frame.h"

// What is kept of a light from frame to frame, on or off. A key of 0: nothing of that part.
struct lf_slot {
    ng_entity entity;
    const struct ng_light_type *type; // an entity may have lights of several types
    struct lf_light_clues *clues;
    struct lf_net_encoding *encoding;
    uint64_t rsm_key, points_key, view_key;
    struct lf_light_observation maps; // LF_RSM_MAPS: what the clues look into
};

// A light that shines in this frame, and what it should be made from.
struct lf_shining {
    struct lf_slot *slot;
    const struct ng_light_maps *maps;
    uint64_t rsm_key, points_key, view_key;
    struct ng_graph_ref token; // of the last pass that redoes a part of it; zero: none
};

struct lf_encoder {
    struct lf_encoder_params params;
    uint64_t reads;  // inputs of the network
    uint64_t gather; // view inputs that the gather reads
    struct lf_view_memory *view;
    const struct lf_slot *viewed; // whose clues lie there; null: nobody's
    struct lf_tracer *tracer;
    struct lf_pixel_clues *pixels;
    NG_ARRAY(struct lf_slot *) slots; // each from calloc: passes hold their addresses
    NG_ARRAY(struct lf_shining) shining;
    NG_ARRAY(struct lf_light_clues *) clues; // of the lights that shine, for the powers
    bool traced;                             // the tracer is at this frame's snapshot
    uint64_t screen_key, powers_key;
    uint64_t most, refused; // bytes that were found to fit; what was refused last
    struct lf_encoder_counters counters;
};

// What the passes of a frame are made from; the lights are in self->shining.
struct lf_encoder_inputs {
    struct lf_encoder *self;
    const struct ng_frame_info *frame;
    const struct ng_gbuffer *gbuffer;
    uint64_t screen_key, powers_key;
};

// ---- encoder_keys.c --------------------------------------------------------------------------------------

// Camera, and everything that it or a mirror ray may meet.
uint64_t lf_encoder_screen_key(const struct lf_encoder *self, const struct ng_frame_info *frame);
// The emitter but for its power, and everything inside of its views.
uint64_t lf_encoder_rsm_key(const struct ng_frame_info *frame, uint32_t light);
// Of networks that know the power itself (`paper`) more depends on it than the gather.
uint64_t lf_encoder_points_key(const struct lf_encoder *self, const struct ng_snapshot *s,
                               const struct lf_shining *light);
uint64_t lf_encoder_powers_key(const struct lf_encoder *self, const struct ng_snapshot *s, uint64_t screen);

// ---- encoder_passes.c ------------------------------------------------------------------------------------

// Declares what this frame has to redo; sets the tokens of the lights and returns that of the powers. Tokens
// are zero where nothing is redone.
struct ng_graph_ref lf_encoder_declare(struct ng_graph *graph, const struct lf_encoder_inputs *in);

#endif
