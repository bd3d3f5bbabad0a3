#include "app/input.h"

#include "base/result.h"

#include <string.h>

void ng_input_begin(struct ng_input *input)
{
    input->scroll = 0;
    memset(input->drag, 0, sizeof input->drag);
    memset(input->clicked, 0, sizeof input->clicked);
    memset(input->pressed, 0, sizeof input->pressed);
    memset(input->shifted, 0, sizeof input->shifted);
    memset(input->held, 0, sizeof input->held);
    memset(input->hurried, 0, sizeof input->hurried);
}

void ng_input_pass(struct ng_input *input, double time)
{
    double seconds = time - input->time;
    if (!(seconds > 0))
        return;
    input->time = time;
    if (seconds > NG_INPUT_LONGEST)
        seconds = NG_INPUT_LONGEST;
    for (int k = 0; k < NG_KEY_COUNT; k++) {
        input->held[k] += input->down[k] ? (float)seconds : 0;
        input->hurried[k] += input->down[k] && input->down[NG_KEY_SHIFT] ? (float)seconds : 0;
    }
}

// More of them, as far as there is room.
static void count(uint8_t *times, uint8_t more)
{
    *times = (uint8_t)(more < UINT8_MAX - *times ? *times + more : UINT8_MAX);
}

void ng_input_key(struct ng_input *input, int key, bool down, double time)
{
    ng_input_pass(input, time);
    input->down[key] = down;
    if (!down)
        return;
    count(&input->pressed[key], 1);
    count(&input->shifted[key], input->down[NG_KEY_SHIFT]);
}

void ng_input_button(struct ng_input *input, enum ng_button button, bool down, double time)
{
    ng_input_pass(input, time);
    input->buttons[button] = down;
    if (!down)
        return;
    count(&input->clicked[button], 1);
    memcpy(input->grip[button], input->pointer, sizeof input->grip[button]);
}

void ng_input_pointer(struct ng_input *input, float x, float y, double time)
{
    const float position[2] = {x, y};
    ng_input_pass(input, time);
    for (int i = 0; i < 2; i++) {
        for (int b = 0; b < NG_BUTTON_COUNT; b++)
            if (input->buttons[b])
                input->drag[b][i] += position[i] - input->pointer[i];
        input->pointer[i] = position[i];
    }
}

void ng_input_scroll(struct ng_input *input, float steps, double time)
{
    ng_input_pass(input, time);
    input->scroll += steps;
}

void ng_input_add(struct ng_input *input, const struct ng_input *next)
{
    const struct ng_input before = *input;
    *input = *next;
    input->scroll += before.scroll;
    for (int b = 0; b < NG_BUTTON_COUNT; b++) {
        input->drag[b][0] += before.drag[b][0];
        input->drag[b][1] += before.drag[b][1];
        count(&input->clicked[b], before.clicked[b]);
    }
    for (int k = 0; k < NG_KEY_COUNT; k++) {
        count(&input->pressed[k], before.pressed[k]);
        count(&input->shifted[k], before.shifted[k]);
        input->held[k] += before.held[k];
        input->hurried[k] += before.hurried[k];
    }
}
