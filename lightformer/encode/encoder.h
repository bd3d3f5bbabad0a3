// The encoding passes of the lights of a frame: a provider that gives each light a node of its own in the
// render graph and publishes what became of it.
//
//     trace:update            rays follow the snapshot
//     screen                  what the camera sees, as the network takes it
//     encode:<light>/rsm      direct VPLs, proxy, reflective shadow map        (lf_encode_light)
//     powers                  what the lights' powers decide                   (lf_encode_powers)
//     encode:<light>/points   the network on VPLs and texels                   (lf_net_encode_light)
//     encode:<light>/clues    shading clues                                    (lf_encode_view)
//     encode:<light>/view     the network on the clues: shadow U-Net and all   (lf_net_encode_view)
//
// The clues of a light are there for its view alone, in memory that all lights use in turn; what the gather
// reads of them is kept.
//
// A part whose inputs have not changed (engine/README.md, "Light observation") is not declared: its last
// result is published again, equal to what the part would make, bit for bit. So an unchanged light costs only
// its share of the gather; where the camera moves, screen, clues and view are redone; the power of a light,
// or its being on, redoes powers alone.
//
//     NG_TRY(lf_encoder_create(&params, &encoder));
//     struct ng_provider provider = lf_encoder_provider(encoder);
//     NG_TRY(ng_composer_register(composer, &provider));        // after G-buffer and light maps
//
// Knows no type of light and nothing of how embeddings are used. Belongs to the thread of its renderer.
#ifndef LF_ENCODE_ENCODER_H
#define LF_ENCODE_ENCODER_H

#include "base/extern_c.h"
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
    uint32_t vpl_count;   // of each light; 0: LF_VPL_COUNT
    uint32_t mirror_rays; // of a picture (struct lf_encode_pixels_params)
    // Bytes of inputs and encodings, and as many of what rays are traced through; 0: what the system has
    // left. A frame that needs more is refused.
    uint64_t memory_limit;
    bool always; // redo everything in every frame (benchmarks, tests)
};

NG_NODISCARD ng_result lf_encoder_create(const struct lf_encoder_params *params, struct lf_encoder **out);
void lf_encoder_destroy(struct lf_encoder **encoder);
// Publishes lf_screen_item and, of each light that shines, lf_embedding_item, in frames that want the method.
struct ng_provider lf_encoder_provider(struct lf_encoder *encoder);
// From the next frame on, as params.always.
void lf_encoder_redo_always(struct lf_encoder *encoder, bool always);

// What the camera sees, one a frame. The ref orders passes: whoever uses the clues reads it as
// NG_USE_HOST_READ, and then finds out whether they were made: a pass that failed leaves another version.
struct lf_screen {
    const struct lf_pixel_clues *clues;
    uint32_t width, height;
    uint64_t version;     // the same version: the same clues, and the same powers of all lights
    const uint64_t *made; // what is there, once ready
    struct ng_graph_ref ready;
};
extern const struct ng_item_type lf_screen_item;

// A light that shines.
struct lf_embedding {
    uint32_t light; // index in the snapshot
    const struct lf_net_encoding *encoding;
    const struct lf_light_clues *clues;
    uint64_t version;          // the same version: the same encoding and clues
    const uint64_t *made;      // as above
    struct ng_graph_ref ready; // as above; zero: nothing of it is redone in this frame
};
extern const struct ng_item_type lf_embedding_item;

// How often each part has been made so far, over all lights.
struct lf_encoder_counters {
    uint64_t trace, screen, powers, rsm, points, clues, view;
};
struct lf_encoder_counters lf_encoder_counters_of(const struct lf_encoder *encoder);

NG_EXTERN_C_END

#endif
