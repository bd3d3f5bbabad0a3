// Frames: when commands reach the queue, and when what they use may die.
//
// Every submission gets the next value of one timeline semaphore, its serial. Two frames are in flight:
// beginning a frame waits for the one before the last. What is destroyed while serial N is being recorded is
// freed once N is done.
//
//     struct ng_cmd *cmd;
//     ng_frame_begin(gpu, &cmd);
//     ... record ...
//     ng_frame_end(gpu, &cmd);                 // then ng_swapchain_present, if an image was acquired
//
// A frame with work for the CPU in the middle is submitted in parts:
//
//     ng_frame_submit(gpu, &cmd, &serial);     // what was recorded so far; cmd is a fresh one
//     ng_gpu_wait(gpu, serial);                // its results are visible to the host
#ifndef NG_GPU_FRAME_H
#define NG_GPU_FRAME_H

#include "base/extern_c.h"
#include "gpu/command.h"

NG_EXTERN_C_BEGIN

#define NG_GPU_FRAMES 2 // in flight

// Waits for the slot's previous frame, frees what waited for it, publishes its timings. `*cmd` is borrowed.
NG_NODISCARD ng_result ng_frame_begin(struct ng_gpu *gpu, struct ng_cmd **cmd);
// Submits what was recorded so far and goes on in a fresh command buffer. `serial` may be null. On failure
// the frame is over and `*cmd` is null. Work before is not ordered against work after except by barriers, as
// within one command buffer.
NG_NODISCARD ng_result ng_frame_submit(struct ng_gpu *gpu, struct ng_cmd **cmd, uint64_t *serial);
// Submits the rest; zeroes `*cmd`. On failure too the frame is over.
NG_NODISCARD ng_result ng_frame_end(struct ng_gpu *gpu, struct ng_cmd **cmd);

// Frames begun so far; the one being recorded is number ng_frame_number - 1.
uint64_t ng_frame_number(const struct ng_gpu *gpu);

// Serial that the commands being recorded will have.
uint64_t ng_gpu_serial(const struct ng_gpu *gpu);
// Waits until the device has done everything up to that serial. A serial not yet submitted is the caller's
// bug.
NG_NODISCARD ng_result ng_gpu_wait(struct ng_gpu *gpu, uint64_t serial);

// Memory for the frame being recorded: mapped, coherent, read by the GPU (uniform and storage), gone when the
// frame is done. Grow-only: after a few frames it allocates nothing.
struct ng_frame_range {
    void *mapped;
    const struct ng_gpu_buffer *buffer;
    uint64_t offset; // a multiple of 256
    uint64_t size;
    VkDeviceAddress address;
};
NG_NODISCARD ng_result ng_frame_alloc(struct ng_gpu *gpu, uint64_t size, struct ng_frame_range *out);
// The same, with `data` in it.
NG_NODISCARD ng_result ng_frame_put(struct ng_gpu *gpu, const void *data, uint64_t size,
                                    struct ng_frame_range *out);

// Commands outside a frame, run at once: for tools and tests.
NG_NODISCARD ng_result ng_immediate_begin(struct ng_gpu *gpu, struct ng_cmd **cmd);
// Submits and waits; zeroes `*cmd`.
NG_NODISCARD ng_result ng_immediate_end(struct ng_gpu *gpu, struct ng_cmd **cmd);

NG_EXTERN_C_END

#endif
