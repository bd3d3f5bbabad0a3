// The Vulkan 1.3 device: instance, choice of the physical device, queue, limits, and what went wrong.
//
// A device serves one thread: every function of engine/gpu that takes a `struct ng_gpu`, or an object made
// from one, is called from the same thread (or under the caller's lock). One queue does graphics, compute and
// copies.
//
// Needed of a driver: Vulkan 1.3 with dynamicRendering, synchronization2, maintenance4, timelineSemaphore,
// bufferDeviceAddress, scalarBlockLayout, hostQueryReset, shaderDrawParameters and
// fragmentStoresAndAtomics. Used where present: VK_KHR_push_descriptor, samplerAnisotropy, imageCubeArray,
// depthClamp, independentBlend, shaderInt64, shaderStorageImageWriteWithoutFormat. Not used: descriptor
// indexing, which lavapipe lacks.
//
// Failure: what the driver refuses is logged once, with the object's name, and returned: NG_ERROR_MEMORY (out
// of host or device memory) or NG_ERROR_DEVICE (no driver, lost device, anything else). After a lost device
// every call that would reach the driver returns NG_ERROR_DEVICE at once and silently; destroying objects and
// the device remains correct. The way on is to destroy the device and create another.
#ifndef NG_GPU_DEVICE_H
#define NG_GPU_DEVICE_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

NG_EXTERN_C_BEGIN

// What every object of this layer begins with, so that the device can name those that outlive it.
struct ng_gpu_live {
    struct ng_gpu_live *previous, *next;
    struct ng_gpu *gpu;
    uint32_t kind;
    char name[48]; // cut where longer
};

struct ng_gpu_params {
    const char *application; // for the driver's own tools; null: "lightformer"
    // Which device: an index as ng_gpu_list gives it, or a part of a name, in any case. Null: the environment
    // variable NG_DEVICE; if that is not set either, the first discrete GPU, else integrated, else virtual,
    // else one that runs on the CPU (lavapipe). A device that is asked for by name and is missing or lacks a
    // feature is an error that lists what there is.
    const char *device;
    // Turns on the Khronos validation layer with synchronization validation. Also on where the environment
    // has NG_VALIDATION=1. NG_ERROR_NOT_FOUND if the layer is not installed.
    bool validation;
    // What the window system needs (glfwGetRequiredInstanceExtensions). Any: VK_KHR_swapchain is required
    // too.
    const char *const *instance_extensions;
    uint32_t instance_extension_count;
    bool no_push_descriptors; // for tests: as on a driver without VK_KHR_push_descriptor
};

struct ng_gpu_internal;

// Read only for callers.
struct ng_gpu {
    VkInstance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    VkQueue queue;
    uint32_t queue_family;
    VkPhysicalDeviceProperties properties; // name, type, limits
    bool validation;                       // the validation layer is on
    bool push_descriptors;                 // else descriptors come from pools of the frame
    bool anisotropy;                       // never of a device that draws on the CPU
    float max_anisotropy;                  // 1 without `anisotropy`
    bool lost;                             // the device is lost
    uint64_t shaders;                      // stands for what replaced shaders hold; 0: all are those built in
    struct ng_gpu_internal *internal;
};

NG_NODISCARD ng_result ng_gpu_create(const struct ng_gpu_params *params, struct ng_gpu **out);
// Waits for the device to be idle. Every object made from it must have been destroyed before: what was not is
// logged as an error, by name, and freed.
void ng_gpu_destroy(struct ng_gpu **gpu);

// Waits until the queue has done everything submitted so far, and frees what waited to be destroyed.
NG_NODISCARD ng_result ng_gpu_wait_idle(struct ng_gpu *gpu);

// Messages of the validation layer (warnings and errors) since creation. Each was logged as an error.
// A test requires 0.
uint32_t ng_gpu_validation_messages(const struct ng_gpu *gpu);

// ---- Which devices there are -----------------------------------------------------------------------------

struct ng_gpu_info {
    uint32_t index; // what --device and NG_DEVICE take
    char name[VK_MAX_PHYSICAL_DEVICE_NAME_SIZE];
    char driver[VK_MAX_DRIVER_NAME_SIZE + VK_MAX_DRIVER_INFO_SIZE +
                2];                      // "llvmpipe, Mesa 22.3.6 (LLVM 15.0.6)"
    const char *type;                    // "discrete GPU", ..., "CPU"; static text
    uint32_t api_version;                // VK_API_VERSION_MAJOR(...) and so on
    uint64_t device_memory, host_memory; // bytes of the heaps that are local to the device, and of the others
    VkPhysicalDeviceLimits limits;
    bool usable;       // has all that the engine needs
    char missing[256]; // else what it lacks: "timelineSemaphore, scalarBlockLayout"
};

// Every device that the Vulkan loader finds, in the loader's order. `*out` is from malloc, owned by the
// caller; null where there is none. No driver at all: an error that says which package brings one,
// NG_ERROR_DEVICE.
NG_NODISCARD ng_result ng_gpu_list(struct ng_gpu_info **out, uint32_t *count);

// ---- What the device holds -------------------------------------------------------------------------------

struct ng_gpu_stats {
    uint64_t memory_reserved; // bytes of VkDeviceMemory
    uint64_t memory_used;     // bytes of it given to objects
    uint64_t memory_peak;     // highest memory_reserved so far
    uint64_t memory_budget;   // bytes of the largest device-local heap
    uint32_t memory_blocks;   // VkDeviceMemory objects
    // Objects alive, those that wait for a frame to end included.
    uint32_t buffers, images, samplers, pipelines, bind_groups, swapchains;
    uint32_t waiting; // destroyed by the caller, still in use by a frame
    // Made since the device was: what stays the same creates nothing.
    uint64_t buffers_made, images_made;
};

struct ng_gpu_stats ng_gpu_stats(const struct ng_gpu *gpu);

// ---- For tests -------------------------------------------------------------------------------------------

// Failures to inject, so that the paths that nobody can provoke at will are tested.
struct ng_gpu_faults {
    uint32_t fail_allocation; // the n-th allocation of device memory or creation of an object from now fails
                              // (1: the next); 0: none
    uint32_t lose_device;     // the n-th submission from now reports a lost device (1: the next); 0: none
};

void ng_gpu_inject_faults(struct ng_gpu *gpu, const struct ng_gpu_faults *faults);

NG_EXTERN_C_END

#endif
