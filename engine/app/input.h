// What a person does at a window, as plain data: made by window.h, or by a test.
//
// Events come one by one, each with its time; the struct then says what happened between two frames. So
// what a program does follows from when keys and buttons were down, not from how long its frames take.
//
//     ng_input_begin(&input);                    // forgets what was before; what is held stays
//     ng_input_key(&input, 'W', true, 1.50);
//     ng_input_key(&input, 'W', false, 1.75);
//     ng_input_pass(&input, 2.00);               // held['W'] is 0.25
#ifndef NG_APP_INPUT_H
#define NG_APP_INPUT_H

#include "base/extern_c.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

// Keys that write something have the code of their letter on a US keyboard, in capitals: 'A', '1', ' ', '.'.
enum ng_key {
    NG_KEY_ESCAPE = 128,
    NG_KEY_TAB,
    NG_KEY_LEFT,
    NG_KEY_RIGHT,
    NG_KEY_UP,
    NG_KEY_DOWN,
    NG_KEY_HOME,
    NG_KEY_END,
    NG_KEY_SHIFT,
    NG_KEY_CONTROL,
    NG_KEY_F1, // to F12 = NG_KEY_F1 + 11
    NG_KEY_COUNT = NG_KEY_F1 + 12,
};

enum ng_button { NG_BUTTON_LEFT, NG_BUTTON_RIGHT, NG_BUTTON_MIDDLE, NG_BUTTON_COUNT };

// `drag`, `scroll`, `pressed` and what follows are what happened since ng_input_begin.
struct ng_input {
    double time;      // seconds of some clock: what it knows up to
    float pointer[2]; // pixels of the framebuffer from its top left corner
    bool buttons[NG_BUTTON_COUNT];
    bool down[NG_KEY_COUNT];
    // Pixels moved while each button was down, x right, y down; also if it is up again by now, so that no
    // drag is lost between two slow frames.
    float drag[NG_BUTTON_COUNT][2];
    float grip[NG_BUTTON_COUNT][2];   // where the pointer was when each button last went down
    float scroll;                     // steps of the wheel, away from the user is positive
    uint8_t clicked[NG_BUTTON_COUNT]; // times that it went down
    uint8_t pressed[NG_KEY_COUNT];    // times that it went down, or repeated
    uint8_t shifted[NG_KEY_COUNT];    // of these, those while Shift was down
    float held[NG_KEY_COUNT];         // seconds that it was down
    float hurried[NG_KEY_COUNT];      // of these, those in which Shift was down, too
};

// Seconds between two events, or an event and ng_input_pass, that count for held keys at most: who was asleep
// meanwhile (a suspended program, a stalled desktop) does not find the camera a mile away.
#define NG_INPUT_LONGEST 0.25

void ng_input_begin(struct ng_input *input);
// Time goes on: until then, what is held is held. Also done by every event below.
void ng_input_pass(struct ng_input *input, double time);
// A letter or one of enum ng_key. One that is down already repeats.
void ng_input_key(struct ng_input *input, int key, bool down, double time);
void ng_input_button(struct ng_input *input, enum ng_button button, bool down, double time);
void ng_input_pointer(struct ng_input *input, float x, float y, double time);
void ng_input_scroll(struct ng_input *input, float steps, double time);
// What happened in `input` and then in `next`, as one, for who did not look in between.
void ng_input_add(struct ng_input *input, const struct ng_input *next);

NG_EXTERN_C_END

#endif
