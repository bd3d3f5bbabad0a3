// The inputs of the network (lightformer/net/inputs.inc), computed on the CPU from a G-buffer, the lights and
// rays: by passes of a frame and by the data set alike.
//
//     struct lf_encode_scene scene = {.tracer = tracer, .jobs = jobs};
//     // what the lights' powers decide, and what the camera sees:
//     NG_TRY(lf_encode_pixels(&scene, &(struct lf_encode_pixels_params){.gbuffer = gbuffer, ...}, pixels));
//     // of each light, where it or what it sees has changed; then, where also camera or screen may have:
//     NG_TRY(lf_encode_light(&scene, light, NULL, clues));
//     NG_TRY(lf_encode_view(&scene, pixels, clues));
//     // every frame: shares of the power, which nothing else depends on
//     lf_encode_powers(snapshot, pixels, all_clues, count);
//
// A light is encoded as if it were on and of brightness 1 (ng_light_unit), then divided by the power that it
// has so: power, on and off change nothing but what lf_encode_powers sets (and light.power, of `paper`), to
// the last bit. The same bytes for any number of threads and for any of the instruction sets of kernels.h.
//
// Memory belongs to the objects, only grows, and is reused: the steady state allocates nothing. One thread
// calls; the work is spread over its jobs. Values never hold a NaN or an infinity, whatever the scene holds.
#ifndef LF_CLUES_CLUES_H
#define LF_CLUES_CLUES_H

#include "base/extern_c.h"
#include "lightformer/clues/captured.h"
#include "lightformer/net/net.h"

NG_EXTERN_C_BEGIN

struct lf_tracer;
struct ng_jobs;
struct ng_snapshot;

struct lf_pixel_clues; // inputs of domain frame and pixel of one picture
struct lf_light_clues; // inputs of domain light, vpl, texel and view of one light

NG_NODISCARD ng_result lf_pixel_clues_create(struct lf_pixel_clues **out);
void lf_pixel_clues_destroy(struct lf_pixel_clues **clues);
NG_NODISCARD ng_result lf_light_clues_create(struct lf_light_clues **out);
void lf_light_clues_destroy(struct lf_light_clues **clues);

// Memory that the view inputs of several lights use one after another.
struct lf_view_memory;
NG_NODISCARD ng_result lf_view_memory_create(struct lf_view_memory **out);
void lf_view_memory_destroy(struct lf_view_memory **memory);

// What all functions read. Borrowed for the call.
struct lf_encode_scene {
    const struct lf_tracer *tracer; // at the snapshot that is encoded
    struct ng_jobs *jobs;           // null: this thread
    // Which inputs are wanted, a bit each (1 << enum lf_net_input); 0: all. Others are left null.
    uint64_t reads;
    // Where lf_encode_view puts its inputs; null: memory of the light's own. What is shared stays until the
    // view of another light is computed (lf_light_clues_keep).
    struct lf_view_memory *view;
};

// The set of inputs that a program reads, for lf_encode_scene.
static inline uint64_t lf_encode_reads(const struct lf_net *net)
{
    uint64_t set = 0;
    for (int i = 0; i < LF_INPUT_COUNT; i++)
        set |= (uint64_t)lf_net_reads(net, (enum lf_net_input)i) << i;
    return set;
}

struct lf_encode_pixels_params {
    struct lf_gbuffer gbuffer;
    uint32_t width, height;
    // Most rays for reflections, three quarters of them for metals; 0: one for every four pixels. Where more
    // pixels reflect, every second, fourth, ... each way has one, in a fixed pattern. What metals show in
    // metals comes on top.
    uint32_t mirror_rays;
};
// Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_encode_pixels(const struct lf_encode_scene *scene,
                                        const struct lf_encode_pixels_params *params,
                                        struct lf_pixel_clues *out);

// How a light's surroundings are found.
struct lf_encode_light_params {
    uint32_t vpl_count; // of direct VPLs; 0: LF_VPL_COUNT. Lights without extent have one
    // The light's rasterized maps, as read back, instead of rays; null: rays. `maps` is used by
    // lf_encode_view as well and has to stay until then.
    const struct lf_light_observation *maps;
};
// The light's own part: `light` is an index in the tracer's snapshot. `params` may be null. Errors, logged:
// NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_encode_light(const struct lf_encode_scene *scene, uint32_t light,
                                       const struct lf_encode_light_params *params,
                                       struct lf_light_clues *out);
// The light's part on screen, after lf_encode_light and lf_encode_pixels. Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_encode_view(const struct lf_encode_scene *scene,
                                      const struct lf_pixel_clues *pixels, struct lf_light_clues *light);

// Copies the view inputs in `set` (1 << enum lf_net_input) from shared memory to the light's own; the others
// become null. Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_light_clues_keep(struct lf_light_clues *light, uint64_t set);

// frame.*, light.share, light.power and pixel.mirror_emission for the powers that a snapshot's lights have
// now. `lights` are clues of lights of that snapshot; all of its lights count.
void lf_encode_powers(const struct ng_snapshot *snapshot, struct lf_pixel_clues *pixels,
                      struct lf_light_clues *const *lights, uint32_t light_count);

// Values as the network takes them; borrowed, until the clues are computed again. Those of the frame and of
// pixels.
const struct lf_net_values *lf_pixel_clues_values(const struct lf_pixel_clues *clues);
// Those of light, VPLs, texels and view.
const struct lf_net_values *lf_light_clues_values(const struct lf_light_clues *clues);
uint32_t lf_light_clues_vpls(const struct lf_light_clues *clues);
uint32_t lf_light_clues_texels(const struct lf_light_clues *clues);
uint32_t lf_light_clues_light(const struct lf_light_clues *clues); // index in the snapshot
// Tells clues that are kept which light of a later snapshot they are of: it may have another index there, and
// what it is sampled by lie elsewhere. Where anything else about it differs but its power, it has to be
// encoded anew before use.
void lf_light_clues_follow(struct lf_light_clues *clues, const struct ng_snapshot *snapshot, uint32_t light);

// Bytes that pictures of a size take at most, whatever they show; `mirror_rays` as above. So that what does
// not fit is refused before it is tried.
struct lf_encode_bytes {
    uint64_t pixels; // of the picture
    uint64_t view;   // of the view inputs of a light, or of all lights if they share memory
    uint64_t light;  // of each light besides, apart from what lf_light_clues_keep copies
};
struct lf_encode_bytes lf_encode_bytes(uint32_t width, uint32_t height, uint32_t mirror_rays);

// Where the time of the last calls went, milliseconds, for budgets and benchmarks.
enum lf_encode_stage {
    LF_ENCODE_PIXELS,     // planes of the G-buffer
    LF_ENCODE_MIRROR,     // rays of reflections and the surfaces that they meet
    LF_ENCODE_TEXELS,     // RSM and direct VPLs
    LF_ENCODE_OCCLUDERS,  // direction and distances
    LF_ENCODE_DIRECT,     // unshadowed direct light
    LF_ENCODE_REACH,      // how much of the light reaches pixels
    LF_ENCODE_HIGHLIGHTS, // whether highlights are in shadow
    LF_ENCODE_BOUNCE,     // light of RSM texels
    LF_ENCODE_AROUND,     // rays over hemispheres, and what they see
    LF_ENCODE_REFLECTED,  // light where rays of reflections end, and what pixels take of it
    LF_ENCODE_STAGES
};
extern const char *const lf_encode_stage_names[LF_ENCODE_STAGES]; // "pixels", ...
double lf_pixel_clues_ms(const struct lf_pixel_clues *clues, enum lf_encode_stage stage);
double lf_light_clues_ms(const struct lf_light_clues *clues, enum lf_encode_stage stage);

NG_EXTERN_C_END

#endif
