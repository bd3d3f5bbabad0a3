#include "app/screen.h"

#include "app/window.h"
#include "base/log.h"
#include "gpu/device.h"
#include "gpu/frame.h"
#include "gpu/image.h"
#include "gpu/swapchain.h"
#include "graph/key.h"

#include <stdlib.h>
#include <string.h>

struct ng_screen_internal {
    struct ng_window *window;
    struct ng_swapchain *swapchain;
    struct ng_graph *graph;
    const uint8_t *pixels; // of the picture; null: none
    uint32_t width, height;
    uint64_t taken; // pictures so far
};

static ng_result open_screen(struct ng_screen *s, const struct ng_screen_params *params)
{
    struct ng_screen_internal *internal = s->internal;
    struct ng_gpu_params gpu = {.device = params->device};
    gpu.instance_extensions = ng_window_extensions(&gpu.instance_extension_count);
    NG_TRY(ng_gpu_create(&gpu, &s->gpu));
    struct ng_swapchain_params swapchain = {.width = params->window->width, .height = params->window->height};
    NG_TRY(ng_window_create_surface(params->window, s->gpu->instance, &swapchain.surface));
    internal->window = params->window;
    NG_TRY(ng_swapchain_create(s->gpu, &swapchain, &internal->swapchain));
    return ng_graph_create(&(struct ng_graph_params){.gpu = s->gpu}, &internal->graph);
}

ng_result ng_screen_create(const struct ng_screen_params *params, struct ng_screen **out)
{
    struct ng_screen *s = calloc(1, sizeof *s);
    struct ng_screen_internal *internal = calloc(1, sizeof *internal);
    *out = NULL;
    if (!s || !internal) {
        free(s);
        free(internal);
        return ng_out_of_memory("a window's screen");
    }
    s->internal = internal;
    ng_result result = open_screen(s, params);
    if (result != NG_OK)
        ng_screen_destroy(&s);
    *out = s;
    return result;
}

void ng_screen_destroy(struct ng_screen **screen)
{
    struct ng_screen *s = *screen;
    *screen = NULL;
    if (!s)
        return;
    ng_graph_destroy(&s->internal->graph);
    ng_swapchain_destroy(&s->internal->swapchain);
    if (s->internal->window)
        ng_window_destroy_surface(s->internal->window);
    ng_gpu_destroy(&s->gpu);
    free(s->internal);
    free(s);
}

void ng_screen_take(struct ng_screen *screen, const uint8_t *rgba, uint32_t width, uint32_t height)
{
    struct ng_screen_internal *s = screen->internal;
    s->pixels = width && height ? rgba : NULL;
    s->width = width;
    s->height = height;
    s->taken++;
}

// ---- Passes ----------------------------------------------------------------------------------------------

struct pass_data {
    const struct ng_screen_internal *screen;
    struct ng_graph_ref from, to;
    uint32_t size[2][2]; // of both
};

static ng_result copy_pixels(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct ng_graph_memory m = ng_pass_memory(ctx, d->to);
    memcpy(m.data, d->screen->pixels, m.size);
    return NG_OK;
}

// The picture changes less often than what is over it, so it stays on the device.
static struct ng_graph_ref declare_picture(const struct ng_screen_internal *s)
{
    struct pass_data data = {.screen = s};
    data.to = ng_graph_persistent_image(s->graph, "picture",
                                        &(struct ng_graph_image_params){.format = VK_FORMAT_R8G8B8A8_UNORM,
                                                                        .width = s->width,
                                                                        .height = s->height},
                                        NULL);
    struct ng_pass *pass =
        ng_graph_add_pass(s->graph, &(struct ng_pass_params){.name = "take",
                                                             .kind = NG_PASS_CPU,
                                                             .run = copy_pixels,
                                                             .data = &data,
                                                             .data_size = sizeof data,
                                                             .key = ng_key_add(NG_KEY, s->taken)});
    return ng_pass_write(pass, data.to, NG_USE_HOST_WRITE);
}

static ng_result blit(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const VkImageSubresourceLayers all = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1};
    bool same = memcmp(d->size[0], d->size[1], sizeof d->size[0]) == 0;
    const VkImageBlit region = {
        .srcSubresource = all,
        .srcOffsets[1] = {(int32_t)d->size[0][0], (int32_t)d->size[0][1], 1},
        .dstSubresource = all,
        .dstOffsets[1] = {(int32_t)d->size[1][0], (int32_t)d->size[1][1], 1},
    };
    vkCmdBlitImage(ctx->cmd->handle, ng_pass_image(ctx, d->from)->handle, ng_pass_layout(ctx, d->from),
                   ng_pass_image(ctx, d->to)->handle, ng_pass_layout(ctx, d->to), 1, &region,
                   same ? VK_FILTER_NEAREST : VK_FILTER_LINEAR);
    return NG_OK;
}

static struct ng_graph_ref declare_blit(struct ng_graph *g, const char *name, const struct pass_data *data)
{
    struct ng_pass *pass = ng_graph_add_pass(
        g, &(struct ng_pass_params){
               .name = name, .kind = NG_PASS_COPY, .run = blit, .data = data, .data_size = sizeof *data});
    ng_pass_read(pass, data->from, NG_USE_COPY_SRC);
    return ng_pass_write(pass, data->to, NG_USE_COPY_DST);
}

// ---- A frame ---------------------------------------------------------------------------------------------

static struct ng_graph_ref declare_display(const struct ng_screen_internal *s, uint32_t width,
                                           uint32_t height)
{
    struct ng_graph_ref display = ng_graph_add_image(
        s->graph, "display",
        &(struct ng_graph_image_params){
            .format = VK_FORMAT_R8G8B8A8_UNORM, .width = width, .height = height, .clear = true});
    if (!s->pixels)
        return display;
    return declare_blit(s->graph, "fit",
                        &(struct pass_data){.from = declare_picture(s),
                                            .to = display,
                                            .size = {{s->width, s->height}, {width, height}}});
}

static ng_result draw(struct ng_screen_internal *s, const struct ng_screen_showing *showing,
                      struct ng_gpu_image *target, struct ng_cmd **cmd)
{
    const uint32_t w = target->width, h = target->height;
    ng_graph_begin(s->graph);
    struct ng_graph_ref display = showing->overlay(showing->user, s->graph, declare_display(s, w, h));
    struct ng_graph_ref to =
        ng_graph_import_image(s->graph, "target", target,
                              &(struct ng_graph_import){.initial = NG_USE_NONE, .final = NG_USE_PRESENT});
    declare_blit(s->graph, "present",
                 &(struct pass_data){.from = display, .to = to, .size = {{w, h}, {w, h}}});
    return ng_graph_execute(s->graph, cmd);
}

ng_result ng_screen_show(struct ng_screen *screen, const struct ng_screen_showing *showing)
{
    struct ng_screen_internal *s = screen->internal;
    struct ng_gpu_image *target = NULL;
    struct ng_cmd *cmd;
    if (!showing->width || !showing->height)
        return NG_OK;
    ng_swapchain_resize(s->swapchain, showing->width, showing->height);
    NG_TRY(ng_frame_begin(screen->gpu, &cmd));
    ng_result drawn = ng_swapchain_acquire(s->swapchain, &target);
    if (drawn == NG_OK && target)
        drawn = draw(s, showing, target, &cmd);
    ng_result ended = ng_frame_end(screen->gpu, &cmd);
    ng_result shown = ended == NG_OK ? ng_swapchain_present(s->swapchain) : NG_OK;
    return drawn != NG_OK ? drawn : ended != NG_OK ? ended : shown;
}
