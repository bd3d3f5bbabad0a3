// What a person does at a window, as plain data: made by window.h, or by a test.
//
// One struct a frame. `drag`, `scroll` and `pressed` are what happened since the frame before.
#ifndef NG_APP_INPUT_H
#define NG_APP_INPUT_H

#include <stdbool.h>

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

struct ng_input {
    float pointer[2]; // pixels of the framebuffer from its top left corner
    // Pixels moved while each button was down, x right, y down; also if it is up again by now, so that no
    // drag is lost between two slow frames.
    float drag[NG_BUTTON_COUNT][2];
    float grip[NG_BUTTON_COUNT][2]; // where the pointer was when each button last went down
    float scroll;                   // steps of the wheel, away from the user is positive
    bool buttons[NG_BUTTON_COUNT];
    bool down[NG_KEY_COUNT];
    bool pressed[NG_KEY_COUNT]; // went down, or repeats
};

#endif
