// The user interface on a device: a window darkens and writes on what is under it, and nothing else.
#include "gpu_test.h"

#include "editor/ui.h"
#include "gpu/frame.h"

#define WIDTH  160
#define HEIGHT 180

struct picture {
    uint8_t pixels[HEIGHT][WIDTH][4];
};

struct rig {
    struct ng_gpu *gpu;
    struct ng_graph *graph;
    struct ng_ui *ui;
};

static struct rig rig_begin(void)
{
    struct rig r = {.gpu = gpu_test_begin()};
    assert_int_equal(ng_graph_create(&(struct ng_graph_params){.gpu = r.gpu}, &r.graph), NG_OK);
    struct ng_ui_params params = {.gpu = r.gpu, .format = VK_FORMAT_R8G8B8A8_UNORM};
    assert_int_equal(ng_ui_create(&params, &r.ui), NG_OK);
    return r;
}

static void rig_end(struct rig *r)
{
    ng_ui_destroy(&r->ui);
    ng_graph_destroy(&r->graph);
    gpu_test_end(r->gpu);
}

// Ends a frame over plain grey.
static void finish(struct rig *r, struct picture *out)
{
    struct ng_cmd *cmd;
    struct ng_graph_memory memory;
    assert_int_equal(ng_frame_begin(r->gpu, &cmd), NG_OK);
    ng_graph_begin(r->graph);
    struct ng_graph_ref picture = ng_graph_add_image(
        r->graph, "picture",
        &(struct ng_graph_image_params){.format = VK_FORMAT_R8G8B8A8_UNORM,
                                        .width = WIDTH,
                                        .height = HEIGHT,
                                        .clear = true,
                                        .clear_value.color.float32 = {0.5f, 0.5f, 0.5f, 1}});
    ng_ui_end(r->ui);
    ng_ui_add_pass(r->ui, r->graph, picture);
    ng_graph_readback(r->graph, "picture");
    assert_int_equal(ng_graph_execute(r->graph, &cmd), NG_OK);
    assert_int_equal(ng_frame_end(r->gpu, &cmd), NG_OK);
    assert_int_equal(ng_graph_readback_get(r->graph, "picture", &memory), NG_OK);
    assert_int_equal(memory.size, sizeof *out);
    memcpy(out, memory.data, sizeof *out);
}

// A frame; with a window if there is a text for it.
static void draw(struct rig *r, const char *text, const struct ng_input *input, struct picture *out)
{
    ng_ui_begin(r->ui, &(struct ng_ui_frame){WIDTH, HEIGHT, 0.1f, input});
    if (text) {
        if (ng_ui_window_begin(r->ui, "title"))
            ng_ui_text(r->ui, "%s", text);
        ng_ui_window_end(r->ui);
    }
    finish(r, out);
}

// A frame with the same word to choose twice; which one was chosen in it, or -1.
static int choose(struct rig *r, const struct ng_input *input)
{
    static struct picture p;
    int chosen = -1;
    ng_ui_begin(r->ui, &(struct ng_ui_frame){WIDTH, HEIGHT, 0.1f, input});
    if (ng_ui_window_begin(r->ui, "title"))
        for (int i = 0; i < 2; i++)
            if (ng_ui_choice(r->ui, i ? "below" : "above", "word", i == 0))
                chosen = i;
    ng_ui_window_end(r->ui);
    finish(r, &p);
    return chosen;
}

static bool is_grey(const uint8_t *pixel)
{
    return pixel[0] == pixel[1] && pixel[1] == pixel[2] && (pixel[0] == 127 || pixel[0] == 128);
}

static void nothing_is_drawn_without_a_window(void **state)
{
    NG_UNUSED(state);
    static struct picture p;
    struct rig r = rig_begin();
    draw(&r, NULL, NULL, &p);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            assert_true(is_grey(p.pixels[y][x]));
    rig_end(&r);
}

static void a_window_covers_its_place_and_is_written_on(void **state)
{
    NG_UNUSED(state);
    static struct picture p, again, other;
    struct rig r = rig_begin();
    draw(&r, "text", NULL, &p); // Dear ImGui measures a new window in its first frame, hidden
    draw(&r, "text", NULL, &p);
    int inside = 0, bright = 0;
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            bool drawn = !is_grey(p.pixels[y][x]);
            assert_false(drawn && (x < 8 || y < 8)); // left of it and above it nothing changed
            inside += drawn;
            bright += p.pixels[y][x][0] > 200;
        }
    }
    assert_in_range(inside, 500, WIDTH * HEIGHT / 2);
    assert_in_range(bright, 20, 500); // letters

    draw(&r, "text", NULL, &again);
    assert_memory_equal(&p, &again, sizeof p);
    draw(&r, "tent", NULL, &other);
    assert_memory_not_equal(&p, &other, sizeof p);
    rig_end(&r);
}

static void a_pointer_on_a_window_is_the_windows(void **state)
{
    NG_UNUSED(state);
    static struct picture p;
    struct rig r = rig_begin();
    struct ng_input on = {.pointer = {20, 30}}, off = {.pointer = {150, 170}};
    for (int i = 0; i < 3; i++)
        draw(&r, "text", &on, &p);
    assert_true(ng_ui_has_pointer(r.ui));
    for (int i = 0; i < 2; i++)
        draw(&r, "text", &off, &p);
    assert_false(ng_ui_has_pointer(r.ui));
    rig_end(&r);
}

static void a_click_chooses_a_word(void **state)
{
    NG_UNUSED(state);
    struct rig r = rig_begin();
    int clicks[2] = {0};
    // Down the left edge of the window's content: each word answers to clicks somewhere, and only it.
    for (float y = 30; y < 80; y += 4) { // below the title: two clicks there fold the window
        struct ng_input input = {.pointer = {18, y}};
        assert_int_equal(choose(&r, &input), -1); // a pointer alone chooses nothing
        input.buttons[NG_BUTTON_LEFT] = true;
        choose(&r, &input);
        input.buttons[NG_BUTTON_LEFT] = false;
        int chosen = choose(&r, &input);
        if (chosen >= 0)
            clicks[chosen]++;
        if (chosen == 0)
            assert_int_equal(clicks[1], 0); // it is above the other
    }
    assert_true(clicks[0] && clicks[1]);
    rig_end(&r);
}

static void a_caption_stands_in_its_corner(void **state)
{
    NG_UNUSED(state);
    static struct picture p;
    struct rig r = rig_begin();
    ng_ui_begin(r.ui, &(struct ng_ui_frame){WIDTH, HEIGHT, 0.1f, NULL});
    ng_ui_caption(r.ui, -5, -5, "%s", "word");
    finish(&r, &p);
    int dark = 0, bright = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            bool drawn = !is_grey(p.pixels[y][x]);
            assert_false(drawn && (x < WIDTH / 2 || x >= WIDTH - 5 || y < HEIGHT / 2 || y >= HEIGHT - 5));
            dark += p.pixels[y][x][0] < 100;
            bright += p.pixels[y][x][0] > 200;
        }
    assert_in_range(dark, 200, 2000);
    assert_in_range(bright, 20, 500); // letters
    rig_end(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_drawn_without_a_window),
        cmocka_unit_test(a_window_covers_its_place_and_is_written_on),
        cmocka_unit_test(a_pointer_on_a_window_is_the_windows),
        cmocka_unit_test(a_click_chooses_a_word),
        cmocka_unit_test(a_caption_stands_in_its_corner),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
