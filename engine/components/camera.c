#include "components/camera.h"

static const struct ng_camera defaults = {
    .fov_y = 0.7f, .height = 2.0f, .near_plane = 0.01f, .exposure = 1.0f};

static const char *const projections[] = {"perspective", "orthographic", NULL};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_camera, fov_y, NG_FIELD_F32, "rad", 0.01f, 3.1f,
             "perspective: vertical field of view"),
    NG_FIELD_CHOICE(struct ng_camera, projection, projections, "a pinhole, or parallel rays"),
    NG_FIELD(struct ng_camera, height, NG_FIELD_F32, "m", 1e-4f, 1e6f, "orthographic: of what is seen"),
    NG_FIELD(struct ng_camera, near_plane, NG_FIELD_F32, "m", 1e-5f, 1e5f, "distance of the near plane"),
    NG_FIELD(struct ng_camera, exposure, NG_FIELD_F32, "", 0.0f, 1e9f,
             "factor on radiance before the tone map"),
    NG_FIELD(struct ng_camera, auto_exposure, NG_FIELD_BOOL, "", 0, 0,
             "the factor is on what a light meter finds in the picture"),
    NG_FIELD(struct ng_camera, background, NG_FIELD_COLOR, "", 0.0f, 1.0f,
             "shown where nothing is seen: linear, of a display, not exposed"),
};

const struct ng_component_desc ng_camera_component = {
    .name = "camera",
    .doc = "a camera that looks along -Z",
    .size = sizeof(struct ng_camera),
    .align = _Alignof(struct ng_camera),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};
