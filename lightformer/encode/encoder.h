// The encoding passes of the lights of a frame: a provider that gives each light a node of its own in the
// render graph and publishes what became of it.
//
//     clues:pixels            what the camera sees, as the network takes it    (lf_clues_pixels)
//     encode:<light>/rsm      direct VPLs, proxy, reflective shadow map        (lf_clues_light)
//     encode:<light>/light    the network on VPLs and texels                   (lf_net_encode_light)
//     encode:<light>/clues    shading clues                                    (lf_clues_view)
//     encode:<light>/view     the network on the clues: shadow U-Net and all   (lf_net_encode_view)
//     clues:arriving          what rays from pixels meet, lit by all lights    (lf_clues_arriving)
//
// All of it lies in buffers of the graph: "clues/pixels", "clues/grid", "clues/reflections" and
// "clues/arriving" of the picture; "encode:<light>/rsm", ".../light" (what the network makes of VPLs and
// texels), ".../hits" (what rays show of it where they end), ".../embedding" and ".../kept" (what the gather
// reads of the clues) of each light; ".../clues" for the time of its view alone, in memory that all lights
// use in turn.
//
// Every pass is declared in every frame, and the graph runs those whose keys say that something has changed
// (graph/key.h; engine/README.md, "Light observation"). So an unchanged light costs only its share of the
// gather; where the camera moves, the clues of pixels and of views are redone, and the views; the power of a
// light, or its being on, redoes the sums over lights alone. What is not redone equals what would be made,
// bit for bit.
//
//     NG_TRY(lf_encoder_create(&params, &encoder));
//     NG_TRY(lf_encoder_join(encoder, composer));              // after G-buffer and light maps
//
// Knows no type of light and nothing of how embeddings are used. Belongs to the thread of its renderer.
#ifndef LF_ENCODE_ENCODER_H
#define LF_ENCODE_ENCODER_H

#include "base/extern_c.h"
#include "graph/graph.h"
#include "graph/provider.h"
#include "lightformer/clues/clues.h"

#include <stdbool.h>

NG_EXTERN_C_BEGIN

struct lf_encoder;
struct lf_net;
struct lf_net_encoding;
struct lf_net_executor;

// How the surroundings of a light are found.
enum lf_rsm_source {
    LF_RSM_RAYS, // by rays on the CPU; the rasterized maps are then not drawn unless another method reads
                 // them
    LF_RSM_MAPS, // read back from the passes rsm:<light>
};

struct lf_encoder_params {
    const struct lf_net *net;         // needed, borrowed: which inputs are wanted
    struct lf_net_executor *executor; // needed, borrowed
    struct ng_jobs *jobs;             // borrowed; null: the caller's thread alone
    const char *method;               // frames that want this method are encoded; borrowed
    enum lf_rsm_source rsm;
    uint32_t vpl_count;       // of each light; 0: LF_VPL_COUNT
    uint32_t reflection_rays; // of a picture (struct lf_clues_pixels_params)
    // Bytes of inputs and encodings, and as many of the ray scene (lightformer/trace/ray_scene.h); 0: what
    // the system has left. A frame that needs more is refused.
    uint64_t memory_limit;
};

NG_NODISCARD ng_result lf_encoder_create(const struct lf_encoder_params *params, struct lf_encoder **out);
// Leaves its composer, if it is in one, which must still exist.
void lf_encoder_destroy(struct lf_encoder **encoder);
// Registers a provider that publishes lf_encoded_pixels_item and, of each light that shines,
// lf_embedding_item, in frames that want the method. Once; the composer is borrowed until lf_encoder_leave.
NG_NODISCARD ng_result lf_encoder_join(struct lf_encoder *encoder, struct ng_composer *composer);
void lf_encoder_leave(struct lf_encoder *self);

// Buffers of the graph that clues lie in; a zero ref: there is none.
struct lf_pixel_buffers {
    struct ng_graph_ref parts[LF_PIXEL_PARTS];
};
struct lf_light_buffers {
    struct ng_graph_ref rsm, hits, light, embedding, kept;
};
// Where the executor works: scratch, which whoever runs it writes.
struct lf_net_work {
    struct ng_graph_ref memory;
    bool fresh; // nothing has been laid out there
};

// What the camera sees, one a frame.
struct lf_encoded_pixels {
    struct lf_pixel_clues *clues;
    uint32_t width, height;
    struct lf_pixel_buffers buffers;
    struct lf_net_work work;
    uint64_t powers_key; // graph/key.h: of the powers of all lights, which are in no buffer
};
extern const struct ng_item_type lf_encoded_pixels_item;

// A light that shines.
struct lf_embedding {
    uint32_t light; // index in the snapshot
    struct lf_net_encoding *encoding;
    struct lf_light_clues *clues;
    struct lf_light_buffers buffers;
};
extern const struct ng_item_type lf_embedding_item;

// For passes that use them: declares reads of all that a pixel's clues lie in, apart from what depends on
// powers; and, inside of such a pass, lends the buffers to the objects that know what is in them.
void lf_read_pixels(struct ng_pass *pass, const struct lf_pixel_buffers *buffers);
void lf_lend_pixels(const struct ng_pass_context *ctx, const struct lf_pixel_buffers *buffers,
                    struct lf_pixel_clues *clues);
void lf_lend_arriving(const struct ng_pass_context *ctx, const struct lf_pixel_buffers *buffers,
                      struct lf_pixel_clues *clues);
// `fresh`: nothing has been laid out there.
void lf_lend_embedding(const struct ng_pass_context *ctx, const struct lf_light_buffers *buffers, bool fresh,
                       struct lf_light_clues *clues, struct lf_net_encoding *encoding);

// A clue, a texel or an embedding as planes: [channels][height][width]. Rows of VPLs and texels are one line.
struct lf_clue {
    uint32_t width, height, channels;
    const float *planes; // valid until the next frame
    float *own;
};
// The buffer of the graph that holds a clue by name ("pixel.normal", "LIGHT/view.diffuse",
// "LIGHT/texel.flux", "LIGHT/embedding.0"; lightformer/net/inputs.inc), for ng_graph_readback: false if there
// is no such clue, or its name does not fit. Lights have the names that they had when they were first seen.
bool lf_encoder_clue_buffer(const char *clue, char *out, size_t size);
// After a frame in which that buffer was read back, and has arrived. NG_ERROR_NOT_FOUND, logged, with the
// reason.
NG_NODISCARD ng_result lf_encoder_clue(const struct lf_encoder *encoder, const char *clue,
                                       struct lf_clue *out);
void lf_clue_finish(struct lf_clue *clue);

// How often each part has been made so far, over all lights.
struct lf_encoder_counters {
    uint64_t pixels, arriving, rsm, light, clues, view;
};
struct lf_encoder_counters lf_encoder_counters_of(const struct lf_encoder *encoder);

NG_EXTERN_C_END

#endif
