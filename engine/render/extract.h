// Extraction: the world at a moment in time -> one snapshot (render/snapshot.h), the only bridge from the
// scene to what draws it.
//
// An extraction skins and subdivides, and lists instances, materials, images and lights. It only reads the
// world: run the world's systems first (render/scene_systems.h: animation and placements).
//
//     NG_TRY(ng_world_run(world, time));
//     NG_TRY(ng_extract(extractor, &params, &snapshot));
//
// What has not changed since the previous extraction is kept, not made again (change ticks of the world);
// buffers only grow, so the steady state allocates nothing.
//
// An extractor belongs to one world and one asset store and remembers the previous extraction (motion,
// versions). One thread at a time. Results do not depend on the number of threads.
#ifndef NG_RENDER_EXTRACT_H
#define NG_RENDER_EXTRACT_H

#include "base/extern_c.h"
#include "components/camera.h"
#include "components/placement.h"
#include "render/snapshot.h"

NG_EXTERN_C_BEGIN

struct ng_assets;
struct ng_extractor;
struct ng_jobs;
struct ng_world;

// How pictures are exposed. Zero: as the camera says.
enum ng_exposure_mode { NG_EXPOSURE_CAMERA, NG_EXPOSURE_AUTO, NG_EXPOSURE_FIXED };
struct ng_exposure {
    enum ng_exposure_mode mode; // AUTO: as a light meter finds (render/meter.h)
    float factor;               // of FIXED, on radiance
    float stops;                // brighter by so many, besides
};

// A camera that is in no world, such as a viewer's own: no query finds it, and no file keeps it.
struct ng_free_camera {
    struct ng_camera lens;
    struct ng_placement placement;
};

struct ng_extract_params {
    struct ng_world *world;         // required, always the same one; not const: queries belong to it
    const struct ng_assets *assets; // required, always the same one
    struct ng_jobs *jobs;           // null: this thread only
    double time;                    // seconds, as given to ng_world_run
    const char *camera;             // name of the camera's entity; null or "": the first camera of the world
    const struct ng_free_camera *free_camera; // instead of it; null: none
    struct ng_exposure exposure;
    uint32_t subpixel; // which of the pictures that are averaged (render/subpixel.h)
    bool still;        // no motion: previous matrices and positions are the current ones (first
                       // frame, jump in time)
};

// Destroy it before its world.
NG_NODISCARD ng_result ng_extractor_create(struct ng_extractor **out);
void ng_extractor_destroy(struct ng_extractor **extractor);

// What extractions had to do so far, for tests and benchmarks.
struct ng_extract_stats {
    uint64_t topologies; // of subdivision cages that were worked out
    uint64_t refined;    // shapes that were refined from the points of their cage
};
struct ng_extract_stats ng_extractor_stats_of(const struct ng_extractor *x);

// `*out` and everything in it belong to the extractor and are valid until its next extraction. Errors,
// logged: NG_ERROR_NOT_FOUND (no camera of that name; a world without any camera gets a default view of the
// scene), NG_ERROR_MEMORY. Things that only degrade the picture (missing geometry, an emitter without a
// light, ...) warn once an entity and go on.
NG_NODISCARD ng_result ng_extract(struct ng_extractor *x, const struct ng_extract_params *p,
                                  const struct ng_snapshot **out);

NG_EXTERN_C_END

#endif
