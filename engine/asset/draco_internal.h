// Meshes compressed by Draco. Source: Google, Draco 1.5; KHR_draco_mesh_compression.
#ifndef NG_ASSET_DRACO_INTERNAL_H
#define NG_ASSET_DRACO_INTERNAL_H

#include "base/extern_c.h"
#include "base/result.h"
#include "scene/component.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_draco;

// NG_ERROR_FORMAT, not logged, with a reason: the bytes are no such mesh. NG_ERROR_MEMORY, the same: it would
// take more than `max_memory` bytes.
NG_NODISCARD ng_result ng_draco_decode(const void *data, size_t size, uint64_t max_memory,
                                       char why[NG_REASON_SIZE], struct ng_draco **out);
void ng_draco_destroy(struct ng_draco **mesh);

uint32_t ng_draco_vertex_count(const struct ng_draco *mesh);
uint32_t ng_draco_index_count(const struct ng_draco *mesh);
// Writes `index_count` indices, each below the vertex count.
void ng_draco_indices(const struct ng_draco *mesh, uint32_t *out);

// Numbers of an attribute as they are stored in glTF: type 5120 to 5126, tightly packed,
// [vertex_count][components]. False if there is no such attribute, or its numbers do not fit.
bool ng_draco_attribute(const struct ng_draco *mesh, uint32_t unique_id, int component_type,
                        uint32_t components, void *out);

NG_EXTERN_C_END

#endif
