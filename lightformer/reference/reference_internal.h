// What the files of a reference share.
#ifndef LF_REFERENCE_REFERENCE_INTERNAL_H
#define LF_REFERENCE_REFERENCE_INTERNAL_H

#include "lightformer/reference/path.h"
#include "lightformer/reference/reference.h"
#include "render/camera.h"

#include <math.h>

// Sums over the samples of a pixel.
struct lf_sums {
    double direct[3], unshadowed[3], indirect[3], emission[3];
    double square[3]; // of beauty
};

struct lf_reference {
    struct lf_reference_params params; // region filled in
    const struct lf_tracer *tracer;
    struct lf_light_choice lights;
    struct lf_sums *sums; // [region.height][region.width]
    uint32_t samples;
    bool unsaved; // no checkpoint has them, though one should
    struct lf_path_stats stats;
    double seconds;
    struct lf_tile *tiles;
    uint32_t tile_count;
    struct ng_camera_rays camera;
};

static inline size_t lf_pixel_count(const struct lf_reference *r)
{
    return (size_t)r->params.region.width * r->params.region.height;
}

// The ray through a point of the whole picture, pixels.
struct lf_ray lf_reference_ray(const struct lf_reference *r, float x, float y);
struct lf_path_scene lf_reference_scene(const struct lf_reference *r, struct lf_path_stats *stats);

// ---- checkpoint.c ----------------------------------------------------------------------------------------
NG_NODISCARD ng_result lf_checkpoint_write(const struct lf_reference *r, const char *path, uint64_t picture);
NG_NODISCARD ng_result lf_checkpoint_read(struct lf_reference *r, const char *path, uint64_t picture);

#endif
