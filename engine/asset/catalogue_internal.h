// What catalogues are made of: a zip, and Java's properties.
#ifndef NG_ASSET_CATALOGUE_INTERNAL_H
#define NG_ASSET_CATALOGUE_INTERNAL_H

#include "asset/catalogue.h"
#include "asset/gltf_internal.h"
#include "base/extern_c.h"

NG_EXTERN_C_BEGIN

// ---- zip.c -----------------------------------------------------------------------------------------------
struct ng_zip;
bool ng_is_zip(const void *data, size_t size);
// Takes `data` (malloc), also on failure. `path` is for messages, copied.
NG_NODISCARD ng_result ng_zip_open(const char *path, void *data, size_t size, struct ng_zip **out);
void ng_zip_close(struct ng_zip **zip);
// A file of the zip, from malloc, with a zero byte behind it; of at most `limit` bytes. Files that are far
// larger than what they are packed into are refused.
NG_NODISCARD ng_result ng_zip_read(struct ng_zip *zip, const char *name, uint64_t limit, void **data,
                                   size_t *size);

// ---- properties.c ----------------------------------------------------------------------------------------
// Calls `each` with every key and value of a .properties file (Java SE, java.util.Properties): Latin-1 with
// \uXXXX in, UTF-8 out. Texts end with the call. It may return false to stop. False when out of memory or
// stopped.
bool ng_properties_read(const char *text, size_t size,
                        bool (*each)(void *user, const char *key, const char *value), void *user);

// ---- catalogue.c, formats.c ------------------------------------------------------------------------------
// Takes the bytes of the file, also on failure.
NG_NODISCARD ng_result ng_catalogue_take(const char *path, void *data, size_t size,
                                         struct ng_catalogue **out);
// A piece as a GLB, from malloc.
NG_NODISCARD ng_result ng_catalogue_glb(const struct ng_catalogue *catalogue, const struct ng_piece *piece,
                                        struct gltf_faults *faults, const struct ng_gltf_params *params,
                                        unsigned char **glb, size_t *size);
// Reads a scene file of any format as glTF or GLB: others are made into one. From malloc.
NG_NODISCARD ng_result ng_format_read(const char *path, const struct ng_gltf_params *params,
                                      struct gltf_faults *faults, void **data, size_t *size);

NG_EXTERN_C_END

#endif
