// Between renderer.c and layers.c.
#ifndef NG_RENDER_RENDERER_INTERNAL_H
#define NG_RENDER_RENDERER_INTERNAL_H

#include "render/renderer.h"

// Asks the graph for what a layer of a method's picture is made of. NG_ERROR_NOT_FOUND, logged, if there is
// no such layer.
NG_NODISCARD ng_result ng_layers_request(struct ng_graph *g, const char *method, const char *name);

// Of the last frame:
bool ng_renderer_was_requested(const struct ng_renderer *r, const char *layer);
bool ng_renderer_has_radiance(const struct ng_renderer *r,
                              const char *part); // "unshadowed", "direct", "indirect"
const char *ng_renderer_method(const struct ng_renderer *r);
const struct ng_snapshot_camera *ng_renderer_camera(const struct ng_renderer *r);
ng_entity ng_renderer_entity(const struct ng_renderer *r, uint32_t index);
// Memory of that name, at least `size` bytes, kept for the next time; null when out of memory.
void *ng_renderer_scratch(struct ng_renderer *r, const char *name, size_t size);

#endif
