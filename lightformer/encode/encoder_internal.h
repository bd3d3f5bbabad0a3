// What the files of the encoder share.
#ifndef LF_ENCODE_ENCODER_INTERNAL_H
#define LF_ENCODE_ENCODER_INTERNAL_H

#include "base/array.h"
#include "lightformer/encode/encoder.h"
#include "lightformer/trace/ray_scene.h"
#include "render/frame.h"

// What the arrays of a light's buffers refer to, on or off. The content is in the graph, under the light's
// name.
struct lf_kept_light {
    ng_entity entity;
    const struct ng_light_type *type; // an entity may have lights of several types
    bool active;                      // in this frame
    struct lf_light_clues *clues;
    struct lf_net_encoding *encoding;
    // Of its buffers: the light's when it was first seen, so that renaming redoes nothing.
    char name[NG_TEXT_SIZE + 32];
    uint32_t views;                // of its RSM
    struct lf_captured_light maps; // LF_RSM_MAPS: what the clues look into
};

// A light that shines in this frame.
struct lf_active_light {
    struct lf_kept_light *kept;
    const struct ng_light_maps *maps;
    struct lf_light_buffers buffers;
    bool fresh;                // its embedding's memory is new
    struct ng_graph_ref clues; // of all inputs of its view, for this frame
};

struct lf_encoder {
    struct lf_encoder_params params;
    uint64_t reads;               // inputs of the network
    uint64_t gather;              // view inputs that the gather reads
    struct ng_composer *composer; // null: in none
    struct lf_pixel_clues *pixels;
    NG_ARRAY(struct lf_kept_light *) kept; // each from calloc: passes hold their addresses
    NG_ARRAY(struct lf_active_light) active;
    NG_ARRAY(struct lf_light_clues *) clues; // of the lights that shine, in the order of `active`
    uint32_t width, height;                  // of the last picture
    uint64_t most, refused;                  // bytes that were found to fit; what was refused last
    struct lf_encoder_counters counters;
};

// Inputs that are sums over all lights.
#define LF_ARRIVING_INPUTS (1ull << LF_INPUT_PIXEL_REFLECTED | 1ull << LF_INPUT_PIXEL_GATHERED)

// What the passes of a frame are made from; the lights are in self->active.
struct lf_encoder_inputs {
    struct lf_encoder *self;
    const struct ng_frame_info *frame;
    const struct ng_gbuffer *gbuffer; // behind lamps
    const struct lf_ray_scene *rays;
    struct lf_pixel_buffers pixels;
    struct lf_net_work work;
};

// ---- encoder_keys.c: what the passes depend on besides what they read ------------------------------------

// Camera, and everything that it or a ray of a reflection may meet: all but lamps.
uint64_t lf_encoder_pixels_key(const struct lf_encoder *self, const struct ng_frame_info *frame);
// The emitter, but for its power where rays look, and everything inside of its views.
uint64_t lf_encoder_rsm_key(const struct lf_encoder *self, const struct ng_frame_info *frame,
                            const struct lf_active_light *light);
// How much a light asks, among so many.
uint64_t lf_encoder_clues_key(const struct ng_snapshot *s);
// Of networks that know the power itself (`paper`) more depends on it than the gather.
uint64_t lf_encoder_light_key(const struct lf_encoder *self, const struct ng_snapshot *s, uint32_t light);
// The powers of all lights, which the gather depends on.
uint64_t lf_encoder_powers_key(const struct ng_snapshot *s);

// ---- encoder_passes.c ------------------------------------------------------------------------------------

// Declares the buffers and passes of the frame; sets those of the lights.
void lf_encoder_declare(struct ng_graph *graph, struct lf_encoder_inputs *in);
// The buffers alone, so that their content stays.
void lf_encoder_keep(struct ng_graph *graph, struct lf_encoder_inputs *in);

#endif
