// Bringing up Vulkan: an instance, a table of required features, a choice among devices. Each candidate is
// described once (struct ng_gpu_info), and the choice, the listing and the error messages all read that
// description.
#include "gpu/device.h"

#include "base/system.h"
#include "gpu/gpu_internal.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define VALIDATION_LAYER "VK_LAYER_KHRONOS_validation"
#define LEAST_MIB        512
#define NO_DRIVER                                                                                            \
    "no Vulkan driver found; install one (Debian: mesa-vulkan-drivers, which runs on the CPU too)"

// ---- Errors ----------------------------------------------------------------------------------------------

const char *ng_gpu_vk_text(VkResult result)
{
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return "out of device memory";
    case VK_ERROR_OUT_OF_POOL_MEMORY:
    case VK_ERROR_FRAGMENTED_POOL:
        return "out of descriptors";
    case VK_ERROR_INITIALIZATION_FAILED:
        return "the driver failed to initialise";
    case VK_ERROR_DEVICE_LOST:
        return "the device was lost";
    case VK_ERROR_MEMORY_MAP_FAILED:
        return "memory cannot be mapped";
    case VK_ERROR_LAYER_NOT_PRESENT:
        return "a layer is missing";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
        return "an extension is missing";
    case VK_ERROR_FEATURE_NOT_PRESENT:
        return "a feature is missing";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
        return "no driver supports it";
    case VK_ERROR_TOO_MANY_OBJECTS:
        return "too many objects";
    case VK_ERROR_FORMAT_NOT_SUPPORTED:
        return "the format is not supported";
    case VK_ERROR_SURFACE_LOST_KHR:
        return "the window's surface was lost";
    case VK_ERROR_NATIVE_WINDOW_IN_USE_KHR:
        return "the window is in use by another";
    default:
        return "the driver refused";
    }
}

static ng_result result_of(VkResult result)
{
    bool memory = result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY ||
                  result == VK_ERROR_OUT_OF_POOL_MEMORY || result == VK_ERROR_FRAGMENTED_POOL ||
                  result == VK_ERROR_MEMORY_MAP_FAILED || result == VK_ERROR_TOO_MANY_OBJECTS;
    return result >= 0 ? NG_OK : memory ? NG_ERROR_MEMORY : NG_ERROR_DEVICE;
}

ng_result ng_gpu_check(struct ng_gpu *gpu, VkResult result, const char *what, const char *name)
{
    if (result >= 0)
        return NG_OK;
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    if (result == VK_ERROR_DEVICE_LOST) {
        gpu->lost = true;
        ng_log_error(
            "gpu: cannot %s '%s': the device %s was lost; restart the program (a driver update may help)",
            what, name, gpu->properties.deviceName);
    } else {
        ng_log_error("gpu: cannot %s '%s': %s (VkResult %d)", what, name, ng_gpu_vk_text(result),
                     (int)result);
    }
    return result_of(result);
}

// Counts down; true when the count is reached.
static bool fault_due(uint32_t *countdown)
{
    return *countdown && --*countdown == 0;
}

bool ng_gpu_fault_allocation(struct ng_gpu *gpu)
{
    return fault_due(&gpu->internal->faults.fail_allocation);
}

void *ng_gpu_host_alloc(struct ng_gpu *gpu, size_t size, const char *name)
{
    void *p = ng_gpu_fault_allocation(gpu) ? NULL : calloc(1, size);
    if (!p)
        ng_log_error("gpu: out of host memory for '%s'", name);
    return p;
}

void ng_gpu_inject_faults(struct ng_gpu *gpu, const struct ng_gpu_faults *faults)
{
    gpu->internal->faults = *faults;
}

// ---- Instance --------------------------------------------------------------------------------------------

static bool environment_flag(const char *name)
{
    const char *value = getenv(name);
    return value && *value && strcmp(value, "0") != 0;
}

static bool has_extension(const VkExtensionProperties *list, uint32_t count, const char *name)
{
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(list[i].extensionName, name) == 0)
            return true;
    return false;
}

// Instance extensions of the loader and drivers (layer null) or of a layer. Null and 0 where there are none.
static VkExtensionProperties *instance_extensions(const char *layer, uint32_t *count)
{
    *count = 0;
    VkExtensionProperties *list = NULL;
    if (vkEnumerateInstanceExtensionProperties(layer, count, NULL) == VK_SUCCESS && *count)
        list = calloc(*count, sizeof *list);
    if (!list || vkEnumerateInstanceExtensionProperties(layer, count, list) < 0)
        *count = 0;
    return list;
}

static bool has_layer(const char *name)
{
    uint32_t count = 0;
    bool found = false;
    vkEnumerateInstanceLayerProperties(&count, NULL);
    VkLayerProperties *layers = calloc(count ? count : 1, sizeof *layers);
    if (layers && vkEnumerateInstanceLayerProperties(&count, layers) >= 0)
        for (uint32_t i = 0; i < count; i++)
            found |= strcmp(layers[i].layerName, name) == 0;
    free(layers);
    return found;
}

struct instance_choice {
    bool validation, debug_utils;
    NG_ARRAY(const char *) extensions;
};

static ng_result choose_extensions(const struct ng_gpu_params *params, struct instance_choice *choice)
{
    uint32_t count = 0, layer_count = 0;
    VkExtensionProperties *have = instance_extensions(NULL, &count);
    VkExtensionProperties *of_layer =
        choice->validation ? instance_extensions(VALIDATION_LAYER, &layer_count) : NULL;
    ng_result r = NG_OK;
    bool room = true;
    for (uint32_t i = 0; i < params->instance_extension_count; i++) {
        const char *name = params->instance_extensions[i];
        room &= ng_array_push(&choice->extensions, name);
        if (!has_extension(have, count, name)) {
            ng_log_error(
                "gpu: the Vulkan driver lacks %s, which the window system needs; render without a window",
                name);
            r = NG_ERROR_DEVICE;
        }
    }
    choice->debug_utils = has_extension(have, count, VK_EXT_DEBUG_UTILS_EXTENSION_NAME) ||
                          has_extension(of_layer, layer_count, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (choice->debug_utils)
        room &= ng_array_push(&choice->extensions, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (has_extension(of_layer, layer_count, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME))
        room &= ng_array_push(&choice->extensions, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    free(have);
    free(of_layer);
    if (!room) {
        ng_log_error("gpu: out of host memory for the list of extensions");
        r = NG_ERROR_MEMORY;
    }
    return r;
}

static ng_result instance_create(const struct ng_gpu_params *params, struct instance_choice *choice,
                                 VkInstance *out)
{
    static const VkValidationFeatureEnableEXT enables[] = {
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    const VkValidationFeaturesEXT features = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                              .enabledValidationFeatureCount = NG_COUNT(enables),
                                              .pEnabledValidationFeatures = enables};
    const char *layer = VALIDATION_LAYER;
    if (choice->validation && !has_layer(layer)) {
        ng_log_error("gpu: validation is asked for, but the Vulkan layer " VALIDATION_LAYER
                     " is not installed (Debian: vulkan-validationlayers)");
        return NG_ERROR_NOT_FOUND;
    }
    NG_TRY(choose_extensions(params, choice));
    const char *application = params->application ? params->application : "lightformer";
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                             .pApplicationName = application,
                             .pEngineName = "lightformer",
                             .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = choice->validation ? &features : NULL,
        .pApplicationInfo = &app,
        .enabledLayerCount = choice->validation ? 1 : 0,
        .ppEnabledLayerNames = &layer,
        .enabledExtensionCount = (uint32_t)choice->extensions.count,
        .ppEnabledExtensionNames = choice->extensions.items,
    };
    VkResult r = vkCreateInstance(&info, NULL, out);
    if (r == VK_ERROR_INCOMPATIBLE_DRIVER)
        ng_log_error("gpu: " NO_DRIVER);
    else if (r < 0)
        ng_log_error("gpu: cannot start Vulkan: %s (VkResult %d)", ng_gpu_vk_text(r), (int)r);
    return result_of(r);
}

static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                 VkDebugUtilsMessageTypeFlagsEXT types,
                                                 const VkDebugUtilsMessengerCallbackDataEXT *data, void *user)
{
    NG_UNUSED(severity);
    NG_UNUSED(types);
    struct ng_gpu_internal *in = user;
    atomic_fetch_add(&in->validation_messages, 1);
    ng_log_error("vulkan validation: %s", data->pMessage);
    return VK_FALSE;
}

static void messenger_create(struct ng_gpu *gpu)
{
    PFN_vkCreateDebugUtilsMessengerEXT create = (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
        gpu->instance, "vkCreateDebugUtilsMessengerEXT");
    VkDebugUtilsMessengerCreateInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity =
            VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = on_message,
        .pUserData = gpu->internal,
    };
    if (!create || create(gpu->instance, &info, NULL, &gpu->internal->messenger) != VK_SUCCESS)
        ng_log_warn("gpu: the validation layer's messages cannot be heard");
}

uint32_t ng_gpu_validation_messages(const struct ng_gpu *gpu)
{
    return atomic_load(&gpu->internal->validation_messages);
}

// ---- What a device has -----------------------------------------------------------------------------------

struct features {
    VkPhysicalDeviceFeatures2 core;
    VkPhysicalDeviceVulkan11Features v11;
    VkPhysicalDeviceVulkan12Features v12;
    VkPhysicalDeviceVulkan13Features v13;
};

static void features_chain(struct features *f)
{
    *f = (struct features){
        .core = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &f->v11},
        .v11 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES, .pNext = &f->v12},
        .v12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, .pNext = &f->v13},
        .v13 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES},
    };
}

// The features used, needed or not; each flag is a VkBool32 somewhere in struct features.
static const struct feature {
    const char *name;
    size_t offset;
    bool required;
} feature_table[] = {
#define FEATURE(place, name, required)                                                                       \
    {                                                                                                        \
#name, offsetof(struct features, place.name), required                                               \
    }
    FEATURE(v11, shaderDrawParameters, true),
    FEATURE(v12, timelineSemaphore, true),
    FEATURE(v12, bufferDeviceAddress, true),
    FEATURE(v12, scalarBlockLayout, true),
    FEATURE(v12, shaderOutputLayer, true),
    FEATURE(v12, hostQueryReset, true),
    FEATURE(v13, dynamicRendering, true),
    FEATURE(v13, synchronization2, true),
    FEATURE(v13, maintenance4, true),
    FEATURE(core.features, fragmentStoresAndAtomics, true),
    FEATURE(core.features, shaderStorageImageWriteWithoutFormat, false),
    FEATURE(core.features, shaderInt64, false),
    FEATURE(core.features, samplerAnisotropy, false),
    FEATURE(core.features, imageCubeArray, false),
    FEATURE(core.features, depthClamp, false),
    FEATURE(core.features, independentBlend, false),
#undef FEATURE
};

static VkBool32 *feature_flag(struct features *f, const struct feature *feature)
{
    return (VkBool32 *)(void *)((char *)f + feature->offset);
}

static const char *type_text(VkPhysicalDeviceType type)
{
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return "CPU";
    default:
        return "other";
    }
}

// Queue family for graphics, compute and copies; UINT32_MAX if there is none.
static uint32_t queue_family(VkPhysicalDevice physical, uint32_t *timestamp_bits)
{
    VkQueueFamilyProperties families[32];
    uint32_t count = NG_COUNT(families);
    const VkQueueFlags need = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families);
    for (uint32_t i = 0; i < count; i++)
        if ((families[i].queueFlags & need) == need) {
            *timestamp_bits = families[i].timestampValidBits;
            return i;
        }
    return UINT32_MAX;
}

static void add_missing(struct ng_gpu_info *info, const char *what)
{
    size_t n = strlen(info->missing);
    snprintf(info->missing + n, sizeof info->missing - n, "%s%s", n ? ", " : "", what);
    info->usable = false;
}

// Features of a 1.3 device; lists what it lacks.
static void describe_features(VkPhysicalDevice physical, struct ng_gpu_info *info)
{
    struct features have;
    features_chain(&have);
    vkGetPhysicalDeviceFeatures2(physical, &have.core);
    for (size_t i = 0; i < NG_COUNT(feature_table); i++)
        if (feature_table[i].required && !*feature_flag(&have, &feature_table[i]))
            add_missing(info, feature_table[i].name);
    VkPhysicalDeviceDriverProperties driver = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                              .pNext = &driver};
    vkGetPhysicalDeviceProperties2(physical, &properties);
    snprintf(info->driver, sizeof info->driver, "%s%s%s", driver.driverName, *driver.driverInfo ? ", " : "",
             driver.driverInfo);
}

static void describe(VkPhysicalDevice physical, uint32_t index, struct ng_gpu_info *info)
{
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceProperties(physical, &properties);
    vkGetPhysicalDeviceMemoryProperties(physical, &memory);
    *info = (struct ng_gpu_info){.index = index,
                                 .type = type_text(properties.deviceType),
                                 .api_version = properties.apiVersion,
                                 .limits = properties.limits,
                                 .usable = true};
    snprintf(info->name, sizeof info->name, "%s", properties.deviceName);
    for (uint32_t i = 0; i < memory.memoryHeapCount; i++)
        *(memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT ? &info->device_memory
                                                                        : &info->host_memory) +=
            memory.memoryHeaps[i].size;
    uint32_t bits;
    if (queue_family(physical, &bits) == UINT32_MAX)
        add_missing(info, "a queue for graphics and compute");
    if (properties.apiVersion < VK_API_VERSION_1_3)
        add_missing(info, "Vulkan 1.3");
    else
        describe_features(physical, info);
}

// All devices and their descriptions; both arrays are the caller's to free, on failure too.
static ng_result devices(VkInstance instance, VkPhysicalDevice **physical, struct ng_gpu_info **infos,
                         uint32_t *count)
{
    *physical = NULL, *infos = NULL, *count = 0;
    VkResult r = vkEnumeratePhysicalDevices(instance, count, NULL);
    if (r < 0 || !*count) {
        ng_log_error("gpu: " NO_DRIVER);
        return NG_ERROR_DEVICE;
    }
    *physical = calloc(*count, sizeof **physical);
    *infos = calloc(*count, sizeof **infos);
    r = *physical && *infos ? vkEnumeratePhysicalDevices(instance, count, *physical)
                            : VK_ERROR_OUT_OF_HOST_MEMORY;
    if (r < 0) {
        ng_log_error("gpu: cannot list the devices: %s", ng_gpu_vk_text(r));
        return result_of(r);
    }
    for (uint32_t i = 0; i < *count; i++)
        describe((*physical)[i], i, &(*infos)[i]);
    return NG_OK;
}

ng_result ng_gpu_list(struct ng_gpu_info **out, uint32_t *count)
{
    *out = NULL, *count = 0;
    struct instance_choice choice = {0};
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice *physical = NULL;
    ng_result r = instance_create(&(struct ng_gpu_params){0}, &choice, &instance);
    if (r == NG_OK)
        r = devices(instance, &physical, out, count);
    if (r != NG_OK) {
        free(*out);
        *out = NULL, *count = 0;
    }
    free(physical);
    ng_array_finish(&choice.extensions);
    vkDestroyInstance(instance, NULL);
    return r;
}

// ---- The choice ------------------------------------------------------------------------------------------

static bool contains_ignoring_case(const char *text, const char *part)
{
    for (; *text; text++) {
        size_t i = 0;
        while (part[i] && tolower((unsigned char)text[i]) == tolower((unsigned char)part[i]))
            i++;
        if (!part[i])
            return true;
    }
    return false;
}

static bool matches(const struct ng_gpu_info *info, const char *wish)
{
    char *end;
    unsigned long index = strtoul(wish, &end, 10);
    return isdigit((unsigned char)*wish) && !*end ? index == info->index
                                                  : contains_ignoring_case(info->name, wish);
}

static int preference(const struct ng_gpu_info *info)
{
    static const char *const order[] = {"CPU", "other", "virtual GPU", "integrated GPU", "discrete GPU"};
    int rank = 0;
    while (strcmp(order[rank], info->type) != 0)
        rank++;
    return rank;
}

static void log_no_match(const struct ng_gpu_info *infos, uint32_t count, const char *wish)
{
    char list[1024] = "";
    for (uint32_t i = 0; i < count; i++) {
        size_t n = strlen(list);
        snprintf(list + n, sizeof list - n, "%s%u '%s'%s%s", i ? ", " : "", infos[i].index, infos[i].name,
                 infos[i].usable ? "" : " lacking ", infos[i].missing);
    }
    if (wish)
        ng_log_error("gpu: no usable device matches '%s'; there is: %s", wish, list);
    else
        ng_log_error("gpu: no usable device; there is: %s", list);
}

// Index of the device to take, or UINT32_MAX (logged). `wish` null: the best.
static uint32_t choose(const struct ng_gpu_info *infos, uint32_t count, const char *wish)
{
    uint32_t best = UINT32_MAX;
    for (uint32_t i = 0; i < count; i++)
        if (infos[i].usable && (!wish || matches(&infos[i], wish)) &&
            (best == UINT32_MAX || preference(&infos[i]) > preference(&infos[best])))
            best = i;
    if (best == UINT32_MAX)
        log_no_match(infos, count, wish);
    return best;
}

// ---- The device ------------------------------------------------------------------------------------------

static ng_result pick_physical(struct ng_gpu *gpu, const char *wish)
{
    VkPhysicalDevice *physical;
    struct ng_gpu_info *infos;
    uint32_t count;
    const char *environment = getenv("NG_DEVICE");
    if (!wish || !*wish)
        wish = environment && *environment ? environment : NULL;
    ng_result r = devices(gpu->instance, &physical, &infos, &count);
    if (r == NG_OK) {
        uint32_t index = choose(infos, count, wish);
        if (index == UINT32_MAX)
            r = wish ? NG_ERROR_NOT_FOUND : NG_ERROR_DEVICE;
        else
            gpu->physical = physical[index];
    }
    free(physical);
    free(infos);
    return r;
}

// Properties of the chosen device that the rest of the code asks for.
static void read_properties(struct ng_gpu *gpu)
{
    VkPhysicalDevicePushDescriptorPropertiesKHR push = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PUSH_DESCRIPTOR_PROPERTIES_KHR};
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                              .pNext = gpu->push_descriptors ? &push : NULL};
    vkGetPhysicalDeviceProperties2(gpu->physical, &properties);
    gpu->properties = properties.properties;
    gpu->internal->max_push_descriptors = push.maxPushDescriptors;
    vkGetPhysicalDeviceMemoryProperties(gpu->physical, &gpu->internal->memory);
    gpu->queue_family = queue_family(gpu->physical, &gpu->internal->timestamp_bits);
}

static bool device_has_extension(struct ng_gpu *gpu, const char *name)
{
    uint32_t count = 0;
    vkEnumerateDeviceExtensionProperties(gpu->physical, NULL, &count, NULL);
    VkExtensionProperties *list = calloc(count ? count : 1, sizeof *list);
    bool has = list && vkEnumerateDeviceExtensionProperties(gpu->physical, NULL, &count, list) >= 0 &&
               has_extension(list, count, name);
    free(list);
    return has;
}

// Turns on what the table names and the device has, and nothing else.
static void choose_features(struct ng_gpu *gpu, struct features *want)
{
    struct features have;
    features_chain(&have);
    features_chain(want);
    vkGetPhysicalDeviceFeatures2(gpu->physical, &have.core);
    for (size_t i = 0; i < NG_COUNT(feature_table); i++)
        *feature_flag(want, &feature_table[i]) = *feature_flag(&have, &feature_table[i]);
    // Lavapipe filters magnified textures with it, too: they show as overlapping discs.
    if (gpu->properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU)
        want->core.features.samplerAnisotropy = VK_FALSE;
    gpu->anisotropy = want->core.features.samplerAnisotropy;
    gpu->max_anisotropy = gpu->anisotropy ? gpu->properties.limits.maxSamplerAnisotropy : 1;
    gpu->internal->cube_arrays = want->core.features.imageCubeArray;
    gpu->internal->depth_clamp = want->core.features.depthClamp;
}

// A device that draws on the CPU takes the system's memory. Its driver (lavapipe) crashes where that ends
// while it starts or compiles shaders, so with too little of it there is no beginning.
static ng_result limit_memory(struct ng_gpu *gpu)
{
    const uint64_t least = (uint64_t)LEAST_MIB << 20;
    struct ng_gpu_internal *in = gpu->internal;
    in->memory_limit = UINT64_MAX;
    if (gpu->properties.deviceType != VK_PHYSICAL_DEVICE_TYPE_CPU)
        return NG_OK;
    in->memory_limit = ng_system_available_memory();
    if (in->memory_limit >= least)
        return NG_OK;
    ng_log_error("gpu: %s needs %d MiB of memory, of which %d MiB are left; end other programs",
                 gpu->properties.deviceName, LEAST_MIB, (int)(in->memory_limit >> 20));
    return NG_ERROR_MEMORY;
}

static ng_result device_create(struct ng_gpu *gpu, const struct ng_gpu_params *params)
{
    const char *extensions[2];
    uint32_t extension_count = 0;
    gpu->push_descriptors =
        !params->no_push_descriptors && device_has_extension(gpu, VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME);
    if (gpu->push_descriptors)
        extensions[extension_count++] = VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME;
    gpu->internal->swapchains = params->instance_extension_count > 0;
    if (gpu->internal->swapchains)
        extensions[extension_count++] = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
    read_properties(gpu);
    NG_TRY(limit_memory(gpu));
    struct features want;
    choose_features(gpu, &want);
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueFamilyIndex = gpu->queue_family,
                                     .queueCount = 1,
                                     .pQueuePriorities = (const float[]){1}};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .pNext = &want.core,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue,
                               .enabledExtensionCount = extension_count,
                               .ppEnabledExtensionNames = extensions};
    NG_TRY(ng_gpu_check(gpu, vkCreateDevice(gpu->physical, &info, NULL, &gpu->device), "open the device",
                        gpu->properties.deviceName));
    vkGetDeviceQueue(gpu->device, gpu->queue_family, 0, &gpu->queue);
    return NG_OK;
}

static void load_functions(struct ng_gpu *gpu, bool debug_utils)
{
    struct ng_gpu_internal *in = gpu->internal;
#define LOAD(name) (PFN_##name) vkGetDeviceProcAddr(gpu->device, #name)
    if (debug_utils) {
        in->set_name = LOAD(vkSetDebugUtilsObjectNameEXT);
        in->label_begin = LOAD(vkCmdBeginDebugUtilsLabelEXT);
        in->label_end = LOAD(vkCmdEndDebugUtilsLabelEXT);
    }
    if (gpu->push_descriptors)
        in->push_descriptors = LOAD(vkCmdPushDescriptorSetKHR);
#undef LOAD
}

void ng_gpu_set_name(struct ng_gpu *gpu, VkObjectType type, uint64_t handle, const char *name)
{
    if (!gpu->internal->set_name || !handle)
        return;
    VkDebugUtilsObjectNameInfoEXT info = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
                                          .objectType = type,
                                          .objectHandle = handle,
                                          .pObjectName = name};
    gpu->internal->set_name(gpu->device, &info);
}

static ng_result open_gpu(struct ng_gpu *gpu, const struct ng_gpu_params *params,
                          struct instance_choice *choice)
{
    NG_TRY(instance_create(params, choice, &gpu->instance));
    if (choice->validation)
        messenger_create(gpu);
    NG_TRY(pick_physical(gpu, params->device));
    NG_TRY(device_create(gpu, params));
    load_functions(gpu, choice->debug_utils);
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_QUEUE, (uint64_t)(uintptr_t)gpu->queue, "queue");
    VkPipelineCacheCreateInfo cache = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    NG_TRY(ng_gpu_check(gpu, vkCreatePipelineCache(gpu->device, &cache, NULL, &gpu->internal->pipeline_cache),
                        "create", "pipeline cache"));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_PIPELINE_CACHE, (uint64_t)gpu->internal->pipeline_cache,
                    "pipeline cache");
    NG_TRY(ng_gpu_frames_init(gpu));
    return ng_gpu_uploads_init(gpu);
}

ng_result ng_gpu_create(const struct ng_gpu_params *params, struct ng_gpu **out)
{
    *out = NULL;
    struct ng_gpu_params none = {0};
    params = params ? params : &none;
    struct ng_gpu *gpu = calloc(1, sizeof *gpu);
    struct ng_gpu_internal *in = calloc(1, sizeof *in);
    if (!gpu || !in) {
        ng_log_error("gpu: out of host memory for the device");
        free(gpu);
        free(in);
        return NG_ERROR_MEMORY;
    }
    struct instance_choice choice = {.validation = params->validation || environment_flag("NG_VALIDATION")};
    gpu->internal = in;
    gpu->validation = choice.validation;
    in->live.next = in->live.previous = &in->live;
    ng_result r = open_gpu(gpu, params, &choice);
    ng_array_finish(&choice.extensions);
    if (r == NG_OK)
        *out = gpu;
    else
        ng_gpu_destroy(&gpu);
    return r;
}

static void close_device(struct ng_gpu *gpu)
{
    vkDeviceWaitIdle(gpu->device);
    ng_gpu_uploads_finish(gpu);
    ng_gpu_frames_finish(gpu);
    ng_gpu_live_finish(gpu);
    ng_gpu_pipelines_finish(gpu);
    ng_gpu_shaders_finish(gpu);
    ng_gpu_samplers_finish(gpu);
    ng_gpu_memory_finish(gpu);
    vkDestroyDevice(gpu->device, NULL);
}

void ng_gpu_destroy(struct ng_gpu **gpu)
{
    struct ng_gpu *g = *gpu;
    if (!g)
        return;
    *gpu = NULL;
    struct ng_gpu_internal *in = g->internal;
    if (g->device)
        close_device(g);
    if (in->messenger) {
        PFN_vkDestroyDebugUtilsMessengerEXT destroy =
            (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(g->instance,
                                                                       "vkDestroyDebugUtilsMessengerEXT");
        destroy(g->instance, in->messenger, NULL);
    }
    vkDestroyInstance(g->instance, NULL);
    free(in);
    free(g);
}

struct ng_gpu_stats ng_gpu_stats(const struct ng_gpu *gpu)
{
    const struct ng_gpu_internal *in = gpu->internal;
    struct ng_gpu_stats s = {
        .memory_reserved = in->memory_reserved,
        .memory_used = in->memory_used,
        .memory_peak = in->memory_peak,
        .memory_blocks = (uint32_t)in->blocks.count,
        .buffers = in->live_count[NG_GPU_KIND_BUFFER],
        .images = in->live_count[NG_GPU_KIND_IMAGE],
        .pipelines = in->live_count[NG_GPU_KIND_PIPELINE],
        .bind_groups = in->live_count[NG_GPU_KIND_BIND_GROUP],
        .swapchains = in->live_count[NG_GPU_KIND_SWAPCHAIN],
        .samplers = (uint32_t)in->samplers.count,
        .waiting = (uint32_t)(in->retired.count - in->retired_first),
        .buffers_made = in->made_count[NG_GPU_KIND_BUFFER],
        .images_made = in->made_count[NG_GPU_KIND_IMAGE],
    };
    for (uint32_t i = 0; i < in->memory.memoryHeapCount; i++)
        if (in->memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT &&
            in->memory.memoryHeaps[i].size > s.memory_budget)
            s.memory_budget = in->memory.memoryHeaps[i].size;
    return s;
}
