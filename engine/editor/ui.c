// A frame's triangles are copied into the frame's own memory and pulled by the vertex shader, so there is no
// buffer to grow or to synchronise; the font is the only resource.
#include "editor/ui.h"

#include "imgui_internal.h"
#include "ui.frag.spv.h"
#include "ui.vert.spv.h"

#include "base/log.h"
#include "gpu/frame.h"
#include "gpu/transfer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

struct ng_ui {
    struct ng_gpu *gpu;
    struct ng_gpu_image *font;
    struct ng_gpu_pipeline *pipeline;
    struct ng_imgui_counts counts;
};

// As in ui.vert.
struct push {
    VkDeviceAddress vertices, indices;
    float pixel[2];
};

static ng_result create_font(struct ng_ui *ui)
{
    uint32_t width, height;
    const unsigned char *pixels = ng_imgui_font(&width, &height);
    struct ng_gpu_image_params image = {
        .name = "ui font", .width = width, .height = height, .format = VK_FORMAT_R8_UNORM};
    NG_TRY(ng_gpu_image_create(ui->gpu, &image, &ui->font));
    struct ng_upload_image_params upload = {.data = pixels, .size = (uint64_t)width * height};
    return ng_upload_image(ui->font, &upload);
}

static ng_result create_pipeline(struct ng_ui *ui, VkFormat format)
{
    static const struct ng_gpu_slot slots[] = {{.type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}};
    struct ng_gpu_graphics_params params = {
        .name = "ui",
        .vertex = NG_SPIRV(ng_spv_ui_vert),
        .fragment = NG_SPIRV(ng_spv_ui_frag),
        .slots = slots,
        .slot_count = NG_COUNT(slots),
        .push_size = sizeof(struct push),
        .color_formats = {format},
        .color_count = 1,
        .blend = NG_GPU_BLEND_OVER,
    };
    return ng_gpu_graphics_create(ui->gpu, &params, &ui->pipeline);
}

ng_result ng_ui_create(const struct ng_ui_params *params, struct ng_ui **out)
{
    *out = NULL;
    struct ng_ui *ui = calloc(1, sizeof *ui);
    if (!ui)
        return ng_out_of_memory("the user interface");
    ui->gpu = params->gpu;
    ng_imgui_create(params->scale > 0 ? params->scale : 1);
    ng_result result = create_font(ui);
    if (result == NG_OK)
        result = create_pipeline(ui, params->format);
    if (result != NG_OK) {
        ng_ui_destroy(&ui);
        return result;
    }
    *out = ui;
    return NG_OK;
}

void ng_ui_destroy(struct ng_ui **ui)
{
    if (!*ui)
        return;
    ng_gpu_pipeline_destroy(&(*ui)->pipeline);
    ng_gpu_image_destroy(&(*ui)->font);
    ng_imgui_destroy();
    free(*ui);
    *ui = NULL;
}

void ng_ui_begin(struct ng_ui *ui, const struct ng_ui_frame *frame)
{
    NG_UNUSED(ui);
    ng_imgui_begin((float)frame->width, (float)frame->height, frame->seconds, frame->input);
}

bool ng_ui_has_pointer(const struct ng_ui *ui)
{
    NG_UNUSED(ui);
    return ng_imgui_has_pointer();
}

bool ng_ui_window_begin(struct ng_ui *ui, const char *title)
{
    NG_UNUSED(ui);
    return ng_imgui_window_begin(title);
}

void ng_ui_window_end(struct ng_ui *ui)
{
    NG_UNUSED(ui);
    ng_imgui_window_end();
}

void ng_ui_text(struct ng_ui *ui, const char *fmt, ...)
{
    NG_UNUSED(ui);
    va_list args;
    va_start(args, fmt);
    ng_imgui_text(fmt, args);
    va_end(args);
}

void ng_ui_same_line(struct ng_ui *ui)
{
    NG_UNUSED(ui);
    ng_imgui_same_line();
}

bool ng_ui_choice(struct ng_ui *ui, const char *group, const char *word, bool chosen)
{
    NG_UNUSED(ui);
    return ng_imgui_choice(group, word, chosen);
}

bool ng_ui_slider(struct ng_ui *ui, const char *name, float *value, float from, float to, const char *format)
{
    NG_UNUSED(ui);
    return ng_imgui_slider(name, value, from, to, format);
}

bool ng_ui_button(struct ng_ui *ui, const char *word)
{
    NG_UNUSED(ui);
    return ng_imgui_button(word);
}

float ng_ui_caption(struct ng_ui *ui, float x, float y, const char *fmt, ...)
{
    NG_UNUSED(ui);
    char text[256];
    va_list args;
    va_start(args, fmt);
    vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    return ng_imgui_caption(x, y, text);
}

// The clip rectangle in whole pixels inside of the picture; false if nothing is left of it.
static bool scissor(const struct ng_imgui_draw *draw, uint32_t width, uint32_t height, VkRect2D *out)
{
    float x0 = fmaxf(draw->clip_min[0], 0), y0 = fmaxf(draw->clip_min[1], 0);
    float x1 = fminf(draw->clip_max[0], (float)width), y1 = fminf(draw->clip_max[1], (float)height);
    if (x1 <= x0 || y1 <= y0)
        return false;
    *out = (VkRect2D){{(int32_t)x0, (int32_t)y0}, {(uint32_t)x1 - (uint32_t)x0, (uint32_t)y1 - (uint32_t)y0}};
    return true;
}

static ng_result draw(const struct ng_pass_context *ctx)
{
    struct ng_ui *ui = ctx->data;
    struct ng_imgui_counts n = ui->counts;
    if (n.indices == 0)
        return NG_OK;
    struct ng_frame_range vertices, indices;
    NG_TRY(ng_frame_alloc(ctx->gpu, (uint64_t)n.vertices * sizeof(struct ng_imgui_vertex), &vertices));
    NG_TRY(ng_frame_alloc(ctx->gpu, (uint64_t)n.indices * sizeof(uint32_t), &indices));
    struct ng_imgui_draw *draws = ng_graph_alloc(ctx->graph, n.draws * sizeof *draws);
    if (!draws)
        return ng_out_of_memory("the user interface");
    ng_imgui_copy(vertices.mapped, indices.mapped, draws);

    struct ng_gpu_binding font = {
        .view = ui->font->view,
        .sampler = ng_gpu_sampler(ctx->gpu, &(struct ng_gpu_sampler_params){.mag_filter = VK_FILTER_LINEAR,
                                                                            .min_filter = VK_FILTER_LINEAR}),
    };
    NG_TRY(ng_cmd_bind(ctx->cmd, ui->pipeline, &font, 1));
    struct push push = {
        vertices.address, indices.address, {2.0f / (float)ctx->width, 2.0f / (float)ctx->height}};
    ng_cmd_push(ctx->cmd, ui->pipeline, &push, sizeof push);
    for (uint32_t i = 0; i < n.draws; i++) {
        VkRect2D clip;
        if (!scissor(&draws[i], ctx->width, ctx->height, &clip))
            continue;
        vkCmdSetScissor(ctx->cmd->handle, 0, 1, &clip);
        vkCmdDraw(ctx->cmd->handle, draws[i].index_count, 1, draws[i].first_index, 0);
    }
    return NG_OK;
}

void ng_ui_end(struct ng_ui *ui)
{
    ui->counts = ng_imgui_end();
}

struct ng_graph_ref ng_ui_add_pass(struct ng_ui *ui, struct ng_graph *graph, struct ng_graph_ref target)
{
    struct ng_pass *pass = ng_graph_add_pass(
        graph, &(struct ng_pass_params){.name = "ui", .kind = NG_PASS_RASTER, .run = draw, .data = ui});
    return ng_pass_write(pass, target, NG_USE_COLOR);
}
