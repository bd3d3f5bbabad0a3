// The inputs of the network (lightformer/net/inputs.inc), computed on the CPU from a G-buffer, the lights and
// rays: by passes of a frame and by the data set alike.
//
//     struct lf_clues_scene scene = {.tracer = tracer, .jobs = jobs};
//     // what the lights' powers decide, and what the camera sees:
//     NG_TRY(lf_clues_pixels(&scene, &(struct lf_clues_pixels_params){.gbuffer = gbuffer, ...}, pixels));
//     // of each light, where it or what it sees has changed; then, where also camera or pixels may have:
//     NG_TRY(lf_clues_light(&scene, light, NULL, clues));
//     NG_TRY(lf_clues_view(&scene, pixels, clues));
//     // every frame: the unit of radiance, shares, and sums over lights, which nothing else depends on
//     lf_clues_set_powers(snapshot, pixels, all_clues, count);
//     NG_TRY(lf_clues_arriving(&scene, pixels, all_clues, count));
//
// A light is encoded as if it were on and of brightness 1 (ng_light_unit), then divided by the power that it
// has so: power, on and off change nothing but what these two set (and light.power, of `paper`), to
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
struct ng_light_gpu;
struct ng_jobs;
struct ng_snapshot;

struct lf_pixel_clues; // inputs of domain frame and pixel of one picture
struct lf_light_clues; // inputs of domain light, vpl, texel and view of one light

NG_NODISCARD ng_result lf_pixel_clues_create(struct lf_pixel_clues **out);
void lf_pixel_clues_destroy(struct lf_pixel_clues **clues);
NG_NODISCARD ng_result lf_light_clues_create(struct lf_light_clues **out);
void lf_light_clues_destroy(struct lf_light_clues **clues);

// What arrays of a picture's clues lie in. Whoever calls may lend memory for each part, at a multiple of 64
// bytes and of the size that lf_clues_bytes tells; without, it is the object's own.
enum lf_pixel_part {
    LF_PIXEL_PLANES_PART, // of inputs
    LF_PIXEL_GRID,        // what is summed at every few pixels only, and hemisphere rays
    LF_PIXEL_REFLECTIONS, // rays of reflections
    LF_PIXEL_ARRIVING,    // pixel.mirror_light, pixel.gathered; the last, as they alone depend on powers
    LF_PIXEL_PARTS
};
void lf_pixel_clues_lend(struct lf_pixel_clues *clues, enum lf_pixel_part part, void *data, uint64_t size);
// The same of a light: lf_clues_light writes the first part, lf_clues_view the second and the third,
// lf_light_clues_keep the last. Hits: what rays from pixels show of the light where they end.
enum lf_light_part { LF_LIGHT_RSM, LF_LIGHT_VIEW, LF_LIGHT_HITS, LF_LIGHT_KEPT, LF_LIGHT_PARTS };
void lf_light_clues_lend(struct lf_light_clues *clues, enum lf_light_part part, void *data, uint64_t size);

// What all functions read. Borrowed for the call.
struct lf_clues_scene {
    const struct lf_tracer *tracer; // at the snapshot that is encoded
    struct ng_jobs *jobs;           // null: this thread
    // Which inputs are wanted, a bit each (1 << enum lf_net_input); 0: all. Others are left null.
    uint64_t reads;
    // Asked between parts that take long, on the caller's thread: true gives them up, and lf_clues_pixels and
    // lf_clues_view return NG_ABANDONED. Null: never.
    bool (*abandon)(const void *user);
    const void *abandon_user;
    // Told how many rays are about to be cast, on any thread; null: nobody is. For benchmarks.
    void (*count_rays)(void *user, uint32_t rays);
    void *count_user;
};

// The set of inputs that a program reads, for lf_clues_scene.
static inline uint64_t lf_clues_reads(const struct lf_net *net)
{
    uint64_t set = 0;
    for (int i = 0; i < LF_INPUT_COUNT; i++)
        set |= (uint64_t)lf_net_reads(net, (enum lf_net_input)i) << i;
    return set;
}

struct lf_clues_pixels_params {
    struct lf_gbuffer gbuffer;
    uint32_t width, height;
    // Most rays for reflections, three quarters of them for metals; 0: one for every four pixels. Where more
    // pixels reflect, every second, fourth, ... each way has one, in a fixed pattern. What metals show in
    // metals comes on top.
    uint32_t reflection_rays;
};
// Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_clues_pixels(const struct lf_clues_scene *scene,
                                       const struct lf_clues_pixels_params *params,
                                       struct lf_pixel_clues *out);

// How a light's surroundings are found.
struct lf_clues_light_params {
    uint32_t vpl_count;                  // of direct VPLs; 0: LF_VPL_COUNT. Lights without extent have one
    const struct ng_light_gpu *observed; // the light as the renderer has observed it; null: it is observed
    // The light's rasterized maps, as read back, instead of rays; null: rays. `maps` is used by
    // lf_clues_view as well and has to stay until then.
    const struct lf_captured_light *maps;
};
// The light's own part: `light` is an index in the tracer's snapshot. `params` may be null. Errors, logged:
// NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_clues_light(const struct lf_clues_scene *scene, uint32_t light,
                                      const struct lf_clues_light_params *params, struct lf_light_clues *out);
// The light's part on screen, after lf_clues_light and lf_clues_pixels. Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_clues_view(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                                     struct lf_light_clues *light);

// Copies the view inputs in `set` (1 << enum lf_net_input) to memory of their own: lf_light_clues_kept has
// them. Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_light_clues_keep(struct lf_light_clues *light, uint64_t set);

// frame.mean_power and light.power for the powers that a snapshot's lights have now, and light.share by the
// frame.radiance of the last lf_clues_arriving, until the next one sets both. `lights` are clues
// of lights of that snapshot; all of its lights count.
void lf_clues_set_powers(const struct ng_snapshot *snapshot, struct lf_pixel_clues *pixels,
                         struct lf_light_clues *const *lights, uint32_t light_count);
// frame.radiance, light.share, and pixel.mirror_light and pixel.gathered: sums over all lights that shine,
// after lf_clues_view of each and lf_clues_set_powers. Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_clues_arriving(const struct lf_clues_scene *scene, struct lf_pixel_clues *pixels,
                                         struct lf_light_clues *const *lights, uint32_t light_count);

// Values as the network takes them; borrowed, until the clues are computed again. Those of the frame and of
// pixels.
const struct lf_net_values *lf_pixel_clues_values(const struct lf_pixel_clues *clues);
// Those of light, VPLs, texels and view.
const struct lf_net_values *lf_light_clues_values(const struct lf_light_clues *clues);
// The same, but that of view inputs those are there that lf_light_clues_keep has copied.
const struct lf_net_values *lf_light_clues_kept(const struct lf_light_clues *clues);
uint32_t lf_light_clues_vpls(const struct lf_light_clues *clues);
uint32_t lf_light_clues_texels(const struct lf_light_clues *clues);
uint32_t lf_light_clues_light(const struct lf_light_clues *clues); // index in the snapshot
// Tells clues that are kept which light of a later snapshot they are of: it may have another index there, and
// what it is sampled by lie elsewhere. Where anything else about it differs but its power, it has to be
// encoded anew before use.
void lf_light_clues_follow(struct lf_light_clues *clues, const struct ng_snapshot *snapshot, uint32_t light);

// Bytes that pictures of a size take at most, whatever they show; `reflection_rays` as above. So that what
// does not fit is refused before it is tried.
struct lf_clues_bytes {
    uint64_t pixels[LF_PIXEL_PARTS];
};
struct lf_clues_bytes lf_clues_bytes(uint32_t width, uint32_t height, uint32_t reflection_rays);
// Of a light's view; of its hits; of what is kept of it; of its RSM of so many views, with so many VPLs (0:
// LF_VPL_COUNT).
uint64_t lf_clues_view_bytes(uint32_t width, uint32_t height);
uint64_t lf_clues_hits_bytes(uint32_t width, uint32_t height, uint32_t reflection_rays);
uint64_t lf_clues_kept_bytes(uint32_t width, uint32_t height, uint64_t set);
uint64_t lf_clues_rsm_bytes(uint32_t vpl_count, uint32_t views);

// Where the time of the last calls went, milliseconds, for budgets and benchmarks.
enum lf_clues_stage {
    LF_CLUES_PIXELS,              // planes of the G-buffer
    LF_CLUES_REFLECTION_RAYS,     // rays of reflections and the surfaces that they meet
    LF_CLUES_TEXELS,              // RSM and direct VPLs
    LF_CLUES_SHADOW_DISTANCE,     // direction and distances
    LF_CLUES_DIRECT,              // unshadowed direct light
    LF_CLUES_VISIBILITY,          // how much of the light pixels see
    LF_CLUES_SPECULAR_VISIBILITY, // how much of the light highlights see
    LF_CLUES_RSM_GATHER,          // light of RSM texels
    LF_CLUES_HEMISPHERE_GATHER,   // rays over hemispheres, and light where they end
    LF_CLUES_REFLECTED_LIGHT,     // light where rays of reflections end
    LF_CLUES_ARRIVING,            // sums over lights where rays end, and what pixels take of them
    LF_CLUES_STAGES
};
extern const char *const lf_clues_stage_names[LF_CLUES_STAGES]; // "pixels", ...
double lf_pixel_clues_ms(const struct lf_pixel_clues *clues, enum lf_clues_stage stage);
double lf_light_clues_ms(const struct lf_light_clues *clues, enum lf_clues_stage stage);

NG_EXTERN_C_END

#endif
