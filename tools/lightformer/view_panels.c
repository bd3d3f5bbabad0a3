#include "view_panels.h"

#include "app/clip_menu.h"
#include "editor/ui.h"
#include "lightformer/methods/methods.h"

#include <stdio.h>

#define LAYERS_A_LINE 5

static void choose_comparison(struct ng_ui *ui, struct view_picture *p)
{
    const char *name;
    for (uint32_t i = 0; (name = view_comparison_name(i)); i++) {
        if (i)
            ng_ui_same_line(ui);
        if (ng_ui_choice(ui, "comparison", name, p->comparison == i))
            p->comparison = i;
    }
}

static void choose_side(struct ng_ui *ui, const char *title, struct view_side *side)
{
    const char *name;
    ng_ui_text(ui, "%s", title);
    for (uint32_t i = 0; (name = lf_method_name(i)); i++) {
        char word[64];
        snprintf(word, sizeof word, "%u %s", i + 1, name);
        if (i)
            ng_ui_same_line(ui);
        if (ng_ui_choice(ui, title, word, side->method == i))
            side->method = i;
    }
    for (uint32_t i = 0; (name = ng_display_layer(i)); i++) {
        if (i % LAYERS_A_LINE)
            ng_ui_same_line(ui);
        if (ng_ui_choice(ui, title, name, side->layer == i))
            side->layer = i;
    }
}

void view_panel_picture(struct ng_ui *ui, struct view_picture *p, float *stops, float most_stops)
{
    if (ng_ui_window_begin(ui, "Picture")) {
        choose_comparison(ui, p);
        choose_side(ui, p->comparison ? "left" : "shown", &p->sides[VIEW_LEFT]);
        if (p->comparison)
            choose_side(ui, "right", &p->sides[VIEW_RIGHT]);
        ng_ui_slider(ui, "exposure", stops, -most_stops, most_stops, "%+.1f EV");
    }
    ng_ui_window_end(ui);
}

// ---- Cameras and clips -----------------------------------------------------------------------------------

static void choose_clip(struct ng_ui *ui, struct view_order *order, const char *word, uint32_t clip)
{
    if (ng_ui_choice(ui, "clips", word, order->clip == clip))
        order->clip = clip;
}

static void choose_clips(struct ng_ui *ui, const struct view_frame *shown, struct view_order *order)
{
    ng_ui_text(ui, "clips");
    choose_clip(ui, order, "first of each thing", NG_CLIPS_FIRST);
    ng_ui_same_line(ui);
    choose_clip(ui, order, "all", NG_CLIPS_ALL);
    ng_ui_same_line(ui);
    choose_clip(ui, order, "none", NG_CLIPS_NONE);
    for (uint32_t i = 0; i < shown->clips.count; i++) {
        const struct view_clip *clip = &shown->clips.items[i];
        char word[128];
        snprintf(word, sizeof word, "%u %s, %.2f s%s", i + 1, clip->name, (double)clip->duration,
                 clip->plays ? ", plays" : "");
        choose_clip(ui, order, word, i);
    }
}

void view_panel_scene(struct ng_ui *ui, const struct view_frame *shown, struct view_order *order)
{
    if (ng_ui_window_begin(ui, "Scene")) {
        ng_ui_text(ui, "cameras");
        for (uint32_t i = 0; i < shown->cameras.count; i++) {
            char word[128];
            snprintf(word, sizeof word, "%u %s", i + 1, shown->cameras.items[i].name);
            if (ng_ui_choice(ui, "cameras", word, order->camera == i)) {
                order->camera = i;
                order->looks++; // again, too: it goes back there
            }
        }
        if (shown->clips.count)
            choose_clips(ui, shown, order);
    }
    ng_ui_window_end(ui);
}

// ---- Times -----------------------------------------------------------------------------------------------

void view_panel_times(struct ng_ui *ui, const struct view_frame *shown)
{
    if (ng_ui_window_begin(ui, "Times")) {
        ng_ui_text(ui, "    CPU     GPU  ms");
        ng_ui_text(ui, "%7.2f          picture", shown->ms);
        ng_ui_text(ui, "%7.2f          world", shown->world_ms);
        ng_ui_text(ui, "%7.2f          extract", shown->extract_ms);
        for (size_t i = 0; i < shown->passes.count; i++) {
            const struct view_pass *p = &shown->passes.items[i];
            ng_ui_text(ui, "%7.2f %7.2f  %s", p->cpu_ms, p->gpu_ms, p->name);
        }
    }
    ng_ui_window_end(ui);
}
