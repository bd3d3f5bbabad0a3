// Values are parsed by kind straight into the command's struct; defaults are text and take the same way, so
// that what --help shows is what the parser accepts.
#include "options.h"

#include "base/file.h"
#include "base/printable.h"
#include "base/result.h"

#include <assert.h>
#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static bool is_argument(const struct cli_option *o)
{
    return o->name[0] != '-';
}

// The i-th word that a choice or a set accepts; null past the end.
static const char *choice(const struct cli_option *o, uint32_t i)
{
    return o->choice ? o->choice(i) : o->choices[i];
}

// ---- Suggestions

// Levenshtein distance, or a large number for long words.
static size_t edit_distance(const char *a, const char *b)
{
    enum { LONGEST = 63 };
    size_t n = strlen(a), m = strlen(b), row[LONGEST + 1];
    if (n > LONGEST || m > LONGEST)
        return SIZE_MAX;
    for (size_t j = 0; j <= m; j++)
        row[j] = j;
    for (size_t i = 1; i <= n; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= m; j++) {
            size_t change = diagonal + (a[i - 1] != b[j - 1]);
            size_t shorter = row[j] < row[j - 1] ? row[j] : row[j - 1];
            diagonal = row[j];
            row[j] = change < shorter + 1 ? change : shorter + 1;
        }
    }
    return row[m];
}

// Keeps the better of `*best` and `candidate`; a word is near if a third of it is right to change.
static void consider(const char *word, const char *candidate, const char **best, size_t *best_distance)
{
    size_t distance = edit_distance(word, candidate);
    if (distance < *best_distance && distance <= (strlen(candidate) + 2) / 3) {
        *best = candidate;
        *best_distance = distance;
    }
}

const char *cli_nearest(const char *word, const char *const *words)
{
    const char *best = NULL;
    size_t distance = SIZE_MAX;
    for (; *words; words++)
        consider(word, *words, &best, &distance);
    return best;
}

static const char *nearest_option(const struct cli_command *command, const char *word)
{
    const char *best = NULL;
    size_t distance = SIZE_MAX;
    for (size_t i = 0; i < command->option_count; i++) {
        if (!is_argument(&command->options[i]))
            consider(word, command->options[i].name, &best, &distance);
    }
    consider(word, "--help", &best, &distance);
    return best;
}

// ---- Values

static bool in_range(const struct cli_option *o, double x)
{
    return x >= o->min && x <= o->max;
}

// The range is that of the number as it is written: it may not fit into `*out`, which no range exceeds.
static bool parse_count(const struct cli_option *o, const char *text, const char **end, uint32_t *out)
{
    if (!isdigit((unsigned char)text[0]))
        return false;
    char *stop;
    unsigned long long n = strtoull(text, &stop, 10);
    *end = stop;
    *out = (uint32_t)n;
    return in_range(o, (double)n);
}

static bool parse_size(const struct cli_option *o, const char *text, struct cli_size *out)
{
    const char *end;
    return parse_count(o, text, &end, &out->width) && *end == 'x' &&
           parse_count(o, end + 1, &end, &out->height) && *end == 0;
}

static bool parse_range(const struct cli_option *o, const char *text, struct cli_range *out)
{
    const char *end;
    out->given = true;
    if (!parse_count(o, text, &end, &out->first))
        return false;
    out->last = out->first;
    if (strncmp(end, "..", 2) == 0 && !parse_count(o, end + 2, &end, &out->last))
        return false;
    return *end == 0 && out->first <= out->last;
}

// The index of the first `length` letters of `text` among an option's words; false if it is none of them.
static bool find_choice(const struct cli_option *o, const char *text, size_t length, uint32_t *out)
{
    const char *word;
    for (uint32_t i = 0; (word = choice(o, i)); i++) {
        if (strlen(word) == length && memcmp(word, text, length) == 0) {
            *out = i;
            return true;
        }
    }
    return false;
}

static bool parse_set(const struct cli_option *o, const char *text, uint32_t *out)
{
    *out = 0;
    for (;; text++) {
        size_t length = strcspn(text, ",");
        uint32_t i;
        if (!find_choice(o, text, length, &i))
            return false;
        *out |= 1u << i;
        text += length;
        if (*text == 0)
            return true;
    }
}

// Parses `text` into the option's place in `values`.
static bool parse_value(const struct cli_option *o, const char *text, void *values)
{
    void *place = (unsigned char *)values + o->offset;
    const char *end;
    switch (o->kind) {
    case CLI_FLAG:
        *(bool *)place = true;
        return true;
    case CLI_COUNT:
        return parse_count(o, text, &end, place) && *end == 0;
    case CLI_REAL: {
        char *stop;
        double x = strtod(text, &stop);
        *(double *)place = x;
        return stop != text && *stop == 0 && isfinite(x) && in_range(o, x);
    }
    case CLI_TEXT:
        *(const char **)place = text;
        return text[0] != 0;
    case CLI_TEXTS: {
        struct cli_texts *texts = place;
        if (text[0] == 0 || texts->count == CLI_MAX_TEXTS)
            return false;
        texts->items[texts->count++] = text;
        return true;
    }
    case CLI_CHOICE:
        return find_choice(o, text, strlen(text), place);
    case CLI_SET:
        return parse_set(o, text, place);
    case CLI_SIZE:
        return parse_size(o, text, place);
    case CLI_RANGE:
        return parse_range(o, text, place);
    }
    return false;
}

// Writes "a, b or c" for what an option accepts.
static void print_accepted(const struct cli_option *o, FILE *out)
{
    switch (o->kind) {
    case CLI_COUNT:
    case CLI_REAL:
        fprintf(out, "a number from %.10g to %.10g", o->min, o->max);
        break;
    case CLI_SIZE:
        fprintf(out, "WIDTHxHEIGHT from %.10gx%.10g to %.10gx%.10g", o->min, o->min, o->max, o->max);
        break;
    case CLI_RANGE:
        fprintf(out, "FIRST..LAST from %.10g to %.10g", o->min, o->max);
        break;
    case CLI_CHOICE:
    case CLI_SET:
        fprintf(out, o->kind == CLI_SET ? "a list of" : "one of");
        for (uint32_t i = 0; choice(o, i); i++)
            fprintf(out, "%s %s", i ? "," : "", choice(o, i));
        break;
    case CLI_TEXTS:
        fprintf(out, "at most %d values that are not empty", CLI_MAX_TEXTS);
        break;
    case CLI_TEXT:
    case CLI_FLAG:
        fprintf(out, "a value that is not empty");
        break;
    }
}

// ---- Parsing

struct parser {
    const struct cli_command *command;
    void *values;
    FILE *err;
    uint64_t given; // a bit for each option
};

// Reports a mistake and says where to read more. Always CLI_WRONG.
static enum cli_parsed wrong(const struct parser *p, const char *fmt, ...) NG_PRINTF(2, 3);
static enum cli_parsed wrong(const struct parser *p, const char *fmt, ...)
{
    char text[1024];
    va_list args;
    va_start(args, fmt);
    vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    ng_print_line(p->err, "lightformer %s: %s (see lightformer %s --help)", p->command->name, text,
                  p->command->name);
    return CLI_WRONG;
}

static enum cli_parsed set_value(struct parser *p, const struct cli_option *o, const char *text)
{
    p->given |= (uint64_t)1 << (o - p->command->options);
    if (parse_value(o, text, p->values))
        return CLI_RUN;
    char shown[256];
    snprintf(shown, sizeof shown, "%s", text);
    ng_make_printable(shown);
    fprintf(p->err, "lightformer %s: %s: \"%s\" is not ", p->command->name, o->name, shown);
    print_accepted(o, p->err);
    fputc('\n', p->err);
    return CLI_WRONG;
}

static enum cli_parsed set_argument(struct parser *p, const char *text)
{
    for (size_t i = 0; i < p->command->option_count; i++) {
        if (is_argument(&p->command->options[i]) && !(p->given >> i & 1))
            return set_value(p, &p->command->options[i], text);
    }
    return wrong(p, "\"%s\" is one argument too many", text);
}

// Finds the option that `word` begins with: "--size", "--size=..." or "-o".
static const struct cli_option *find_option(const struct cli_command *command, const char *word)
{
    size_t length = strcspn(word, "=");
    for (size_t i = 0; i < command->option_count; i++) {
        const struct cli_option *o = &command->options[i];
        if (is_argument(o))
            continue;
        if (strlen(o->name) == length && memcmp(o->name, word, length) == 0)
            return o;
        if (o->letter && length == 2 && word[1] == o->letter)
            return o;
    }
    return NULL;
}

// Handles argv[i], which begins with a dash; returns how many words it took in `*taken`.
static enum cli_parsed set_option(struct parser *p, char **argv, int left, int *taken)
{
    const char *word = argv[0], *equals = strchr(word, '=');
    const struct cli_option *o = find_option(p->command, word);
    *taken = 1;
    if (!o) {
        const char *near = nearest_option(p->command, word);
        if (near)
            return wrong(p, "there is no %s; did you mean %s?", word, near);
        return wrong(p, "there is no %s", word);
    }
    if (o->kind == CLI_FLAG)
        return equals ? wrong(p, "%s takes no value", o->name) : set_value(p, o, "");
    if (equals)
        return set_value(p, o, equals + 1);
    if (left < 2)
        return wrong(p, "%s needs a value: %s", o->name, o->value);
    *taken = 2;
    return set_value(p, o, argv[1]);
}

static bool asks_for_help(int argc, char **argv)
{
    for (int i = 0; i < argc && strcmp(argv[i], "--") != 0; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
            return true;
    }
    return false;
}

static bool was_given(const struct parser *p, const char *name)
{
    for (size_t i = 0; i < p->command->option_count; i++)
        if (p->given >> i & 1 && strcmp(p->command->options[i].name, name) == 0)
            return true;
    return false;
}

// Of options that were given together, or alone: what has no meaning without another, or beside it, is
// refused.
static enum cli_parsed check_company(const struct parser *p)
{
    for (size_t i = 0; i < p->command->option_count; i++) {
        const struct cli_option *o = &p->command->options[i];
        if (!(p->given >> i & 1))
            continue;
        for (size_t k = 0; o->excludes && o->excludes[k]; k++)
            if (was_given(p, o->excludes[k]))
                return wrong(p, "%s and %s exclude each other", o->name, o->excludes[k]);
        if (o->needs && !was_given(p, o->needs))
            return wrong(p, "%s needs %s", o->name, o->needs);
    }
    return CLI_RUN;
}

// Gives every option that was not given its default.
static enum cli_parsed set_defaults(struct parser *p)
{
    for (size_t i = 0; i < p->command->option_count; i++) {
        const struct cli_option *o = &p->command->options[i];
        if (p->given >> i & 1)
            continue;
        if (o->flags & CLI_REQUIRED)
            return wrong(p, "%s is missing", o->name);
        if (o->fallback) {
            bool ok = parse_value(o, o->fallback, p->values);
            assert(ok && "a default that its own table refuses");
            NG_UNUSED(ok);
        }
    }
    return CLI_RUN;
}

enum cli_parsed cli_parse(const struct cli_command *command, int argc, char **argv, void *values, FILE *err)
{
    assert(command->option_count <= 64);
    if (asks_for_help(argc, argv))
        return CLI_HELP;
    memset(values, 0, command->values_size);
    struct parser p = {.command = command, .values = values, .err = err};
    bool options_end = false;
    for (int i = 0, taken; i < argc; i += taken) {
        enum cli_parsed result;
        taken = 1;
        if (!options_end && strcmp(argv[i], "--") == 0) {
            options_end = true;
            continue;
        }
        if (!options_end && argv[i][0] == '-' && argv[i][1])
            result = set_option(&p, &argv[i], argc - i, &taken);
        else
            result = set_argument(&p, argv[i]);
        if (result != CLI_RUN)
            return result;
    }
    enum cli_parsed company = check_company(&p);
    return company == CLI_RUN ? set_defaults(&p) : company;
}

// ---- Help

static void print_usage_word(const struct cli_option *o, FILE *out)
{
    bool required = o->flags & CLI_REQUIRED;
    fputs(required ? " " : " [", out);
    if (o->letter)
        fprintf(out, "-%c", o->letter);
    else
        fputs(o->name, out);
    if (!is_argument(o) && o->value)
        fprintf(out, " %s", o->value);
    fputs(required ? "" : "]", out);
}

static void print_option(const struct cli_option *o, FILE *out)
{
    char left[64];
    snprintf(left, sizeof left, "%s%c%s%s%s%s", o->letter ? "-" : "", o->letter ? o->letter : ' ',
             o->letter ? ", " : "", o->name, o->value && !is_argument(o) ? " " : "",
             o->value && !is_argument(o) ? o->value : "");
    fprintf(out, "  %-24s %s", o->letter ? left : left + 1, o->doc);
    if (o->kind == CLI_CHOICE || o->kind == CLI_SET) {
        fprintf(out, ": ");
        for (uint32_t i = 0; choice(o, i); i++)
            fprintf(out, "%s%s", i ? ", " : "", choice(o, i));
    }
    if (o->fallback)
        fprintf(out, " (default %s)", o->fallback);
    fputc('\n', out);
}

void cli_help(const struct cli_command *command, FILE *out)
{
    fprintf(out, "usage: lightformer %s", command->name);
    for (size_t i = 0; i < command->option_count; i++)
        print_usage_word(&command->options[i], out);
    fprintf(out, "\n\n%s\n\n", command->summary);
    for (size_t i = 0; i < command->option_count; i++)
        print_option(&command->options[i], out);
    fprintf(out, "  %-24s %s\n", "--help", "this text");
    if (command->notes)
        fprintf(out, "\n%s\n", command->notes);
}

// ---- The canonical command

// Appends to a string of limited size; false once it does not fit.
struct text {
    char *out;
    size_t used, size;
    bool fits;
};

static void append(struct text *t, const char *fmt, ...) NG_PRINTF(2, 3);
static void append(struct text *t, const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    int n = vsnprintf(t->out + t->used, t->size - t->used, fmt, args);
    va_end(args);
    t->fits = t->fits && n >= 0 && (size_t)n < t->size - t->used;
    if (t->fits)
        t->used += (size_t)n;
}

static void append_set(struct text *t, const struct cli_option *o, uint32_t set)
{
    const char *comma = "";
    for (uint32_t i = 0; choice(o, i); i++) {
        if (set >> i & 1) {
            append(t, "%s%s", comma, choice(o, i));
            comma = ",";
        }
    }
}

static void append_value(struct text *t, const struct cli_option *o, const void *place)
{
    const struct cli_size *size = place;
    const struct cli_range *range = place;
    switch (o->kind) {
    case CLI_COUNT:
        append(t, "%u", *(const uint32_t *)place);
        break;
    case CLI_REAL:
        append(t, "%.9g", *(const double *)place);
        break;
    case CLI_TEXT:
        append(t, "%s",
               is_argument(o) || o->flags & CLI_PATH ? ng_path_name(*(const char *const *)place)
                                                     : *(const char *const *)place);
        break;
    case CLI_CHOICE:
        append(t, "%s", choice(o, *(const uint32_t *)place));
        break;
    case CLI_SET:
        append_set(t, o, *(const uint32_t *)place);
        break;
    case CLI_SIZE:
        append(t, "%ux%u", size->width, size->height);
        break;
    case CLI_RANGE:
        append(t, "%u..%u", range->first, range->last);
        break;
    case CLI_FLAG:
    case CLI_TEXTS:
        break;
    }
}

// Whether a value is worth writing: zero is what an option that was not given, and has no default, leaves.
static bool has_value(const struct cli_option *o, const void *place)
{
    switch (o->kind) {
    case CLI_FLAG:
        return *(const bool *)place;
    case CLI_TEXT:
        return *(const char *const *)place != NULL;
    case CLI_SET:
        return *(const uint32_t *)place != 0;
    case CLI_RANGE:
        return ((const struct cli_range *)place)->given;
    case CLI_TEXTS:
        return false;
    case CLI_COUNT:
    case CLI_CHOICE:
        return o->fallback || *(const uint32_t *)place != 0;
    case CLI_REAL:
        return o->fallback || *(const double *)place != 0;
    case CLI_SIZE:
        return o->fallback || ((const struct cli_size *)place)->width != 0;
    }
    return true;
}

bool cli_canonical(const struct cli_command *command, const void *values, char *out, size_t size)
{
    struct text t = {.out = out, .size = size, .fits = true};
    append(&t, "lightformer %s", command->name);
    for (size_t i = 0; i < command->option_count; i++) {
        const struct cli_option *o = &command->options[i];
        const void *place = (const unsigned char *)values + o->offset;
        if (!(o->flags & CLI_PICTURE) || !has_value(o, place))
            continue;
        if (!is_argument(o))
            append(&t, " %s", o->name);
        if (o->kind != CLI_FLAG)
            append(&t, " ");
        append_value(&t, o, place);
    }
    return t.fits;
}
