// Bytes to the device and back.
//
// Uploads go through a staging ring and are submitted ahead of the next commands: whatever is recorded after
// the call sees them, without a barrier of the caller's. They are for content that is loaded once or rarely;
// data that changes every frame belongs in ng_frame_alloc or in an NG_GPU_MEMORY_UPLOAD buffer. Readbacks
// wait for the device.
#ifndef NG_GPU_TRANSFER_H
#define NG_GPU_TRANSFER_H

#include "base/extern_c.h"
#include "gpu/buffer.h"
#include "gpu/image.h"

NG_EXTERN_C_BEGIN

// `data` is copied before the call returns. Mapped buffers are written directly: then no frame in flight may
// be using that range.
NG_NODISCARD ng_result ng_upload_buffer(struct ng_gpu_buffer *buffer, uint64_t offset, const void *data,
                                        uint64_t size);

struct ng_upload_image_params {
    // Texels, tightly packed: level after level, and within a level layer after layer; row 0 first.
    const void *data;
    uint64_t size;          // must be exactly what the levels and layers take
    uint32_t mip, mips;     // mips 0: the rest
    uint32_t layer, layers; // layers 0: the rest
    VkImageLayout layout;   // of these subresources afterwards; 0: SHADER_READ_ONLY_OPTIMAL
};
// The subresources' old content is lost. Bytes that such an upload takes: ng_transfer_image_size.
NG_NODISCARD ng_result ng_upload_image(struct ng_gpu_image *image,
                                       const struct ng_upload_image_params *params);

// Waits for everything submitted; what the current frame has recorded and not submitted is not seen.
NG_NODISCARD ng_result ng_readback_buffer(struct ng_gpu_buffer *buffer, uint64_t offset, void *out,
                                          uint64_t size);

struct ng_readback_image_params {
    VkImageLayout layout;   // in which the subresources are and stay; needed, not UNDEFINED
    uint32_t mip, mips;     // mips 0: the rest
    uint32_t layer, layers; // layers 0: the rest
    void *out;              // packed as in ng_upload_image_params
    uint64_t size;
};
NG_NODISCARD ng_result ng_readback_image(struct ng_gpu_image *image,
                                         const struct ng_readback_image_params *params);

// Bytes of these levels and layers, tightly packed; mips, layers 0: the rest.
uint64_t ng_transfer_image_size(const struct ng_gpu_image *image, uint32_t mip, uint32_t mips, uint32_t layer,
                                uint32_t layers);

NG_EXTERN_C_END

#endif
