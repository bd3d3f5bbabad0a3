#define _POSIX_C_SOURCE 200809L // fmemopen
#include "test.h"

#include "tools/lightformer/json.h"
#include "tools/lightformer/options.h"

struct grow {
    const char *plant;
    bool quick, greenhouse, field;
    uint32_t count, method, parts;
    double height;
    struct cli_size bed;
    struct cli_range days;
    struct cli_texts outputs;
};

static const char *const methods[] = {"sun", "lamp", NULL};
static const char *const parts[] = {"root", "leaf", "flower", NULL};

static const char *const not_with_field[] = {"--greenhouse", "--count", NULL};

static const struct cli_option grow_options[] = {
    CLI_ARGUMENT(struct grow, plant, "PLANT", "what to grow"),
    {.name = "--output",
     .letter = 'o',
     .kind = CLI_TEXTS,
     .offset = offsetof(struct grow, outputs),
     .value = "FILE"},
    {.name = "--quick", .kind = CLI_FLAG, .flags = CLI_PICTURE, .offset = offsetof(struct grow, quick)},
    {.name = "--count",
     .kind = CLI_COUNT,
     .offset = offsetof(struct grow, count),
     .value = "N",
     .fallback = "3",
     .min = 1,
     .max = 100},
    {.name = "--method",
     .kind = CLI_CHOICE,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct grow, method),
     .value = "NAME",
     .fallback = "lamp",
     .choices = methods},
    {.name = "--parts",
     .kind = CLI_SET,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct grow, parts),
     .value = "LIST",
     .choices = parts},
    {.name = "--height",
     .kind = CLI_REAL,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct grow, height),
     .value = "M",
     .fallback = "0.5",
     .min = -1,
     .max = 10},
    {.name = "--bed",
     .kind = CLI_SIZE,
     .offset = offsetof(struct grow, bed),
     .value = "WxH",
     .fallback = "2x1",
     .min = 1,
     .max = 50},
    {.name = "--days",
     .kind = CLI_RANGE,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct grow, days),
     .value = "A..B",
     .min = 0,
     .max = 365},
    {.name = "--greenhouse", .kind = CLI_FLAG, .offset = offsetof(struct grow, greenhouse), .needs = "--bed"},
    {.name = "--field", .kind = CLI_FLAG, .offset = offsetof(struct grow, field), .excludes = not_with_field},
};

static const struct cli_command grow_command = {
    .name = "grow",
    .summary = "Grows a plant.",
    .options = grow_options,
    .option_count = NG_COUNT(grow_options),
    .values_size = sizeof(struct grow),
};

// Parses a line of words; what was said on errors goes to `said`.
static enum cli_parsed parse(const char *line, struct grow *out, char *said, size_t said_size)
{
    static char copy[512];
    char *argv[32];
    int argc = 0;
    snprintf(copy, sizeof copy, "%s", line);
    for (char *word = strtok(copy, " "); word; word = strtok(NULL, " "))
        argv[argc++] = word;
    FILE *err = fmemopen(said, said_size, "w");
    assert_non_null(err);
    enum cli_parsed result = cli_parse(&grow_command, argc, argv, out, err);
    fclose(err);
    return result;
}

static void expect_wrong(const char *line, const char *message)
{
    struct grow g;
    char said[512] = "";
    assert_int_equal(parse(line, &g, said, sizeof said), CLI_WRONG);
    if (!strstr(said, message))
        fail_msg("\"%s\" should say \"%s\" and says: %s", line, message, said);
    assert_ptr_equal(strchr(said, '\n'), said + strlen(said) - 1); // one line
}

static void defaults_are_those_of_the_table(void **state)
{
    NG_UNUSED(state);
    struct grow g;
    char said[512] = "";
    assert_int_equal(parse("fern", &g, said, sizeof said), CLI_RUN);
    assert_string_equal(g.plant, "fern");
    assert_false(g.quick);
    assert_int_equal(g.count, 3);
    assert_int_equal(g.method, 1);
    assert_int_equal(g.parts, 0);
    assert_true(g.height == 0.5);
    assert_int_equal(g.bed.width, 2);
    assert_int_equal(g.bed.height, 1);
    assert_false(g.days.given);
    assert_string_equal(said, "");
}

static void every_kind_of_value_is_parsed(void **state)
{
    NG_UNUSED(state);
    struct grow g;
    char said[512] = "";
    assert_int_equal(parse("--count=100 -o a.png --quick --method sun --parts root,flower --height -0.25 "
                           "--bed 50x7 --days 3..365 --output b.exr -- --fern",
                           &g, said, sizeof said),
                     CLI_RUN);
    assert_string_equal(g.plant, "--fern");
    assert_true(g.quick);
    assert_int_equal(g.count, 100);
    assert_int_equal(g.method, 0);
    assert_int_equal(g.parts, 5);
    assert_true(g.height == -0.25);
    assert_int_equal(g.bed.width, 50);
    assert_int_equal(g.bed.height, 7);
    assert_true(g.days.given && g.days.first == 3 && g.days.last == 365);
    assert_int_equal(g.outputs.count, 2);
    assert_string_equal(g.outputs.items[0], "a.png");
    assert_string_equal(g.outputs.items[1], "b.exr");

    assert_int_equal(parse("fern --days 7 --parts flower,root,leaf,root", &g, said, sizeof said), CLI_RUN);
    assert_true(g.days.given && g.days.first == 7 && g.days.last == 7);
    assert_int_equal(g.parts, 7);
}

static void mistakes_are_named(void **state)
{
    NG_UNUSED(state);
    expect_wrong("", "PLANT is missing");
    expect_wrong("fern moss", "\"moss\" is one argument too many");
    expect_wrong("fern --hieght 2", "there is no --hieght; did you mean --height?");
    expect_wrong("fern --zzzzzzzzz", "there is no --zzzzzzzzz (see");
    expect_wrong("fern --count", "--count needs a value: N");
    expect_wrong("fern --quick=yes", "--quick takes no value");
    expect_wrong("fern --method moon", "one of sun, lamp");
    expect_wrong("fern --parts root,stem", "a list of root, leaf, flower");
    expect_wrong("fern --parts root,", "a list of root, leaf, flower");
}

static void company_is_checked(void **state)
{
    NG_UNUSED(state);
    struct grow g;
    char said[64] = "";
    expect_wrong("fern --greenhouse", "--greenhouse needs --bed");
    expect_wrong("fern --count 3 --field", "--field and --count exclude each other");
    expect_wrong("fern --field --bed 1x1 --greenhouse", "--field and --greenhouse exclude each other");
    assert_int_equal(parse("fern --greenhouse --count 3 --bed 2x1", &g, said, sizeof said), CLI_RUN);
    assert_int_equal(parse("fern --field --bed 2x1", &g, said, sizeof said), CLI_RUN); // a default is no wish
}

static void numbers_are_held_to_their_range(void **state)
{
    NG_UNUSED(state);
    static const char *const refused[] = {
        "--count 0",   "--count 101", "--count 4294967297", "--count -1",  "--count 3x",
        "--count=",    "--height 11", "--height nan",       "--height 1m", "--bed 0x5",
        "--bed 51x5",  "--bed 5",     "--bed 5x5x5",        "--bed x5",    "--days 0..366",
        "--days 5..4", "--days 1..",  "--days ..2",         "--days a",
    };
    for (size_t i = 0; i < NG_COUNT(refused); i++) {
        char line[64];
        snprintf(line, sizeof line, "fern %s", refused[i]);
        expect_wrong(line, "is not ");
    }
}

static void help_shows_every_option(void **state)
{
    NG_UNUSED(state);
    struct grow g;
    char text[4096] = "", said[64] = "";
    assert_int_equal(parse("--count 0 --help", &g, said, sizeof said), CLI_HELP);
    FILE *out = fmemopen(text, sizeof text, "w");
    assert_non_null(out);
    cli_help(&grow_command, out);
    fclose(out);
    for (size_t i = 0; i < NG_COUNT(grow_options); i++)
        assert_non_null(strstr(text, grow_options[i].name));
    assert_non_null(strstr(text, "sun, lamp (default lamp)"));
}

static void canonical_command_holds_what_makes_the_picture(void **state)
{
    NG_UNUSED(state);
    struct grow g;
    char text[256], said[64] = "";
    assert_int_equal(
        parse("/garden/fern --count 9 -o x.png --parts flower,root --days 2", &g, said, sizeof said),
        CLI_RUN);
    assert_true(cli_canonical(&grow_command, &g, text, sizeof text));
    assert_string_equal(text,
                        "lightformer grow fern --method lamp --parts root,flower --height 0.5 --days 2..2");
    char small[20];
    assert_false(cli_canonical(&grow_command, &g, small, sizeof small));

    // Run again, it is its own canonical command.
    struct grow again;
    char second[256];
    assert_int_equal(parse(text + strlen("lightformer grow "), &again, said, sizeof said), CLI_RUN);
    assert_true(cli_canonical(&grow_command, &again, second, sizeof second));
    assert_string_equal(text, second);
}

static void json_is_nested_and_escaped(void **state)
{
    NG_UNUSED(state);
    char text[256] = "";
    struct json j = {.out = fmemopen(text, sizeof text, "w")};
    assert_non_null(j.out);
    json_object(&j, NULL);
    json_text(&j, "a\"b", "x\\y\n");
    json_array(&j, "list");
    json_number(&j, NULL, 0.5);
    json_number(&j, NULL, 1.0 / 0.0);
    json_end(&j);
    json_array(&j, "empty");
    json_end(&j);
    json_bool(&j, "yes", true);
    json_end(&j);
    fclose(j.out);
    assert_string_equal(text, "{\n  \"a\\\"b\": \"x\\\\y\\u000a\",\n  \"list\": [\n    0.5,\n    null\n  ],\n"
                              "  \"empty\": [],\n  \"yes\": true\n}\n");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_those_of_the_table),
        cmocka_unit_test(every_kind_of_value_is_parsed),
        cmocka_unit_test(mistakes_are_named),
        cmocka_unit_test(company_is_checked),
        cmocka_unit_test(numbers_are_held_to_their_range),
        cmocka_unit_test(help_shows_every_option),
        cmocka_unit_test(canonical_command_holds_what_makes_the_picture),
        cmocka_unit_test(json_is_nested_and_escaped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
