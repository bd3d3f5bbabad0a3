// The windows of `lightformer view` over its picture.
#ifndef LIGHTFORMER_VIEW_PANELS_H
#define LIGHTFORMER_VIEW_PANELS_H

#include "view_studio.h"

struct ng_ui;

// Methods and layers to choose from, and the exposure, in stops up and down.
void view_panel_picture(struct ng_ui *ui, struct view_picture *picture, float *stops, float most_stops);
// Cameras and clips to choose from.
void view_panel_scene(struct ng_ui *ui, const struct view_frame *shown, struct view_order *order);
// The passes of the last frame and what each took.
void view_panel_times(struct ng_ui *ui, const struct view_frame *shown);

#endif
