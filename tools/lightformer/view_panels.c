#include "view_panels.h"

#include "app/clip_menu.h"
#include "app/stage.h"
#include "editor/ui.h"

#include <stdio.h>

#define LAYERS_A_LINE 5
#define EDGE          8.0f
#define CHOICES_END   245.0f // where the times have room below

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
    const struct method *method;
    const char *name;
    ng_ui_text(ui, "%s", title);
    for (uint32_t i = 0; (method = method_of(METHOD_VIEW, i)); i++) {
        char word[64];
        snprintf(word, sizeof word, "%c %s", method->key, method->name);
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

void view_panel_picture(struct ng_ui *ui, struct view_picture *p)
{
    if (ng_ui_window_begin(ui, "Picture", EDGE, EDGE)) {
        choose_comparison(ui, p);
        choose_side(ui, p->comparison ? "left" : "shown", &p->sides[VIEW_LEFT]);
        if (p->comparison)
            choose_side(ui, "right", &p->sides[VIEW_RIGHT]);
    }
    ng_ui_window_end(ui);
}

// ---- Clips -----------------------------------------------------------------------------------------------

static void choose_clips(struct ng_ui *ui, struct ng_clip_menu *clips, const char *word, uint32_t choice)
{
    if (ng_ui_choice(ui, "clips", word, ng_clip_menu_choice(clips) == choice))
        ng_clip_menu_play(clips, choice);
}

void view_panel_clips(struct ng_ui *ui, struct ng_clip_menu *clips)
{
    const char *name;
    if (ng_ui_window_begin(ui, "Clips", EDGE, EDGE)) {
        choose_clips(ui, clips, "first of each thing", NG_CLIPS_FIRST);
        ng_ui_same_line(ui);
        choose_clips(ui, clips, "all", NG_CLIPS_ALL);
        ng_ui_same_line(ui);
        choose_clips(ui, clips, "none", NG_CLIPS_NONE);
        for (uint32_t i = 0; (name = ng_clip_menu_name(clips, i)); i++) {
            char word[128];
            snprintf(word, sizeof word, "%u %.64s, %.2f s%s", i + 1, name,
                     (double)ng_clip_menu_duration(clips, i), ng_clip_menu_plays(clips, i) ? ", plays" : "");
            choose_clips(ui, clips, word, i);
        }
    }
    ng_ui_window_end(ui);
}

// ---- Times -----------------------------------------------------------------------------------------------

// A pass whose count of runs has not changed since the panel was last shown took no part in the frame.
static bool ran(const struct view_times *times, size_t pass, uint64_t runs)
{
    return pass < times->runs.count && runs != times->runs.items[pass];
}

void view_panel_times(struct ng_ui *ui, struct view_times *times, struct ng_stage *stage, double frame_ms,
                      bool below_choices)
{
    size_t count;
    const struct ng_pass_stats *passes = ng_graph_stats(ng_renderer_graph(stage->renderer), &count);
    if (ng_ui_window_begin(ui, "Times", EDGE, below_choices ? CHOICES_END : EDGE)) {
        ng_ui_text(ui, "    CPU     GPU  ms");
        ng_ui_text(ui, "%7.2f          frame", frame_ms);
        ng_ui_text(ui, "%7.2f          world", stage->world_ms);
        ng_ui_text(ui, "%7.2f          extract", stage->extract_ms);
        for (size_t i = 0; i < count; i++)
            if (ran(times, i, passes[i].runs))
                ng_ui_text(ui, "%7.2f %7.2f  %s", passes[i].cpu_ms, passes[i].gpu_ms, passes[i].name);
    }
    ng_ui_window_end(ui);
    if (!ng_array_resize(&times->runs, count))
        return; // and nothing is listed
    for (size_t i = 0; i < count; i++)
        times->runs.items[i] = passes[i].runs;
}

void view_times_finish(struct view_times *times)
{
    ng_array_finish(&times->runs);
}
