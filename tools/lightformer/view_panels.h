// The windows of `lightformer view` over its picture.
#ifndef LIGHTFORMER_VIEW_PANELS_H
#define LIGHTFORMER_VIEW_PANELS_H

#include "view_picture.h"

#include "base/array.h"

struct ng_clip_menu;
struct ng_stage;
struct ng_ui;

// Methods and layers to choose from.
void view_panel_picture(struct ng_ui *ui, struct view_picture *picture);

// Clips to choose from.
void view_panel_clips(struct ng_ui *ui, struct ng_clip_menu *clips);

// The passes of the last frame and what each took. Zero to begin with.
struct view_times {
    NG_ARRAY(uint64_t) runs; // of each pass, when last shown
};
void view_panel_times(struct ng_ui *ui, struct view_times *times, struct ng_stage *stage, double frame_ms,
                      bool below_choices);
void view_times_finish(struct view_times *times);

#endif
