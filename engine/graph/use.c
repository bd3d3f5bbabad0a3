// One row a word. Stages are given for each kind of pass, since "sampled" means other stages in a draw than
// in a dispatch; everything else follows from the word alone.
#include "graph/use.h"

#include <assert.h>

#define NO_DESCRIPTOR VK_DESCRIPTOR_TYPE_MAX_ENUM

#define SHADERS (VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT)
#define DEPTH_TEST                                                                                           \
    (VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT)
#define COMPUTE  VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT
#define TRANSFER VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT

static const struct ng_use_info table[NG_USE_COUNT] = {
    [NG_USE_NONE] = {.name = "none", .image_descriptor = NO_DESCRIPTOR, .buffer_descriptor = NO_DESCRIPTOR},
    [NG_USE_COLOR] = {.name = "color",
                      .stages = {[NG_PASS_RASTER] = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT},
                      .access =
                          VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                      .layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                      .image_usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                      .image_descriptor = NO_DESCRIPTOR,
                      .buffer_descriptor = NO_DESCRIPTOR,
                      .reads = true,
                      .writes = true},
    [NG_USE_DEPTH] = {.name = "depth",
                      .stages = {[NG_PASS_RASTER] = DEPTH_TEST},
                      .access = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
                                VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
                      .layout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
                      .image_usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
                      .image_descriptor = NO_DESCRIPTOR,
                      .buffer_descriptor = NO_DESCRIPTOR,
                      .reads = true,
                      .writes = true},
    [NG_USE_DEPTH_READ] = {.name = "depth read",
                           .stages = {[NG_PASS_RASTER] = DEPTH_TEST},
                           .access = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT,
                           .layout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL,
                           .image_usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
                           .image_descriptor = NO_DESCRIPTOR,
                           .buffer_descriptor = NO_DESCRIPTOR,
                           .reads = true},
    [NG_USE_SAMPLED] = {.name = "sampled",
                        .stages = {[NG_PASS_RASTER] = SHADERS, [NG_PASS_COMPUTE] = COMPUTE},
                        .access = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                        .layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                        .image_usage = VK_IMAGE_USAGE_SAMPLED_BIT,
                        .image_descriptor = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                        .buffer_descriptor = NO_DESCRIPTOR,
                        .reads = true},
    [NG_USE_STORAGE_READ] = {.name = "storage read",
                             .stages = {[NG_PASS_RASTER] = SHADERS, [NG_PASS_COMPUTE] = COMPUTE},
                             .access = VK_ACCESS_2_SHADER_STORAGE_READ_BIT,
                             .layout = VK_IMAGE_LAYOUT_GENERAL,
                             .image_usage = VK_IMAGE_USAGE_STORAGE_BIT,
                             .buffer_usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                             .image_descriptor = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
                             .buffer_descriptor = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                             .reads = true},
    [NG_USE_STORAGE_WRITE] = {.name = "storage write",
                              .stages = {[NG_PASS_RASTER] = SHADERS, [NG_PASS_COMPUTE] = COMPUTE},
                              .access = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                              .layout = VK_IMAGE_LAYOUT_GENERAL,
                              .image_usage = VK_IMAGE_USAGE_STORAGE_BIT,
                              .buffer_usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                              .image_descriptor = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
                              .buffer_descriptor = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                              .writes = true},
    [NG_USE_STORAGE_READ_WRITE] = {.name = "storage read write",
                                   .stages = {[NG_PASS_RASTER] = SHADERS, [NG_PASS_COMPUTE] = COMPUTE},
                                   .access = VK_ACCESS_2_SHADER_STORAGE_READ_BIT |
                                             VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                   .layout = VK_IMAGE_LAYOUT_GENERAL,
                                   .image_usage = VK_IMAGE_USAGE_STORAGE_BIT,
                                   .buffer_usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                   .image_descriptor = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
                                   .buffer_descriptor = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                   .reads = true,
                                   .writes = true,
                                   .needs_content = true},
    [NG_USE_UNIFORM] = {.name = "uniform",
                        .stages = {[NG_PASS_RASTER] = SHADERS, [NG_PASS_COMPUTE] = COMPUTE},
                        .access = VK_ACCESS_2_UNIFORM_READ_BIT,
                        .buffer_usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                        .image_descriptor = NO_DESCRIPTOR,
                        .buffer_descriptor = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                        .reads = true},
    [NG_USE_VERTEX] = {.name = "vertex",
                       .stages = {[NG_PASS_RASTER] = VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT},
                       .access = VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT,
                       .buffer_usage = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT,
                       .image_descriptor = NO_DESCRIPTOR,
                       .buffer_descriptor = NO_DESCRIPTOR,
                       .reads = true},
    [NG_USE_INDEX] = {.name = "index",
                      .stages = {[NG_PASS_RASTER] = VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT},
                      .access = VK_ACCESS_2_INDEX_READ_BIT,
                      .buffer_usage = VK_BUFFER_USAGE_INDEX_BUFFER_BIT,
                      .image_descriptor = NO_DESCRIPTOR,
                      .buffer_descriptor = NO_DESCRIPTOR,
                      .reads = true},
    [NG_USE_INDIRECT] = {.name = "indirect",
                         .stages = {[NG_PASS_RASTER] = VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
                                    [NG_PASS_COMPUTE] = VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT},
                         .access = VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT,
                         .buffer_usage = VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
                         .image_descriptor = NO_DESCRIPTOR,
                         .buffer_descriptor = NO_DESCRIPTOR,
                         .reads = true},
    [NG_USE_COPY_SRC] = {.name = "copy source",
                         .stages = {[NG_PASS_COPY] = TRANSFER},
                         .access = VK_ACCESS_2_TRANSFER_READ_BIT,
                         .layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                         .image_usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                         .buffer_usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                         .image_descriptor = NO_DESCRIPTOR,
                         .buffer_descriptor = NO_DESCRIPTOR,
                         .reads = true},
    [NG_USE_COPY_DST] = {.name = "copy destination",
                         .stages = {[NG_PASS_COPY] = TRANSFER},
                         .access = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                         .layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                         .image_usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                         .buffer_usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                         .image_descriptor = NO_DESCRIPTOR,
                         .buffer_descriptor = NO_DESCRIPTOR,
                         .writes = true},
    [NG_USE_HOST_READ] = {.name = "host read",
                          .stages = {[NG_PASS_CPU] = VK_PIPELINE_STAGE_2_HOST_BIT},
                          .access = VK_ACCESS_2_HOST_READ_BIT,
                          .image_descriptor = NO_DESCRIPTOR,
                          .buffer_descriptor = NO_DESCRIPTOR,
                          .reads = true,
                          .host = true},
    [NG_USE_HOST_WRITE] = {.name = "host write",
                           .stages = {[NG_PASS_CPU] = VK_PIPELINE_STAGE_2_HOST_BIT},
                           .access = VK_ACCESS_2_HOST_WRITE_BIT,
                           .image_descriptor = NO_DESCRIPTOR,
                           .buffer_descriptor = NO_DESCRIPTOR,
                           .writes = true,
                           .host = true},
    [NG_USE_HOST_READ_WRITE] = {.name = "host read write",
                                .stages = {[NG_PASS_CPU] = VK_PIPELINE_STAGE_2_HOST_BIT},
                                .access = VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_HOST_WRITE_BIT,
                                .image_descriptor = NO_DESCRIPTOR,
                                .buffer_descriptor = NO_DESCRIPTOR,
                                .reads = true,
                                .writes = true,
                                .needs_content = true,
                                .host = true},
    // Nothing in the frame waits for presentation, so it has a layout and neither stage nor access.
    [NG_USE_PRESENT] = {.name = "present",
                        .layout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR,
                        .image_descriptor = NO_DESCRIPTOR,
                        .buffer_descriptor = NO_DESCRIPTOR,
                        .reads = true},
};

const struct ng_use_info *ng_use_info(enum ng_use use)
{
    assert((unsigned)use < NG_USE_COUNT);
    return &table[use];
}

VkAccessFlags2 ng_use_write_access(VkAccessFlags2 access)
{
    return access & (VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT |
                     VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT |
                     VK_ACCESS_2_HOST_WRITE_BIT);
}

// The host reaches images through linear copies, hence without a layout of their own.
bool ng_use_of_images(enum ng_use use)
{
    return table[use].layout != VK_IMAGE_LAYOUT_UNDEFINED || table[use].host;
}

bool ng_use_of_buffers(enum ng_use use)
{
    return table[use].buffer_usage || table[use].host;
}
