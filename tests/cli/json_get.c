// Prints a value of a JSON document on standard input: json_get PATH, such as "passes.0.name". Objects and
// arrays print as how many members they have. Exits with 1 if the document is malformed or has no such value.
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const cJSON *find(const cJSON *value, const char *path)
{
    while (value && *path) {
        char name[128];
        size_t length = strcspn(path, ".");
        snprintf(name, sizeof name, "%.*s", (int)length, path);
        value = cJSON_IsArray(value) ? cJSON_GetArrayItem(value, atoi(name))
                                     : cJSON_GetObjectItemCaseSensitive(value, name);
        path += length + (path[length] == '.');
    }
    return value;
}

static void print(const cJSON *value)
{
    if (cJSON_IsString(value))
        puts(value->valuestring);
    else if (cJSON_IsNumber(value))
        printf("%.9g\n", value->valuedouble);
    else if (cJSON_IsBool(value))
        puts(cJSON_IsTrue(value) ? "true" : "false");
    else if (cJSON_IsNull(value))
        puts("null");
    else
        printf("%d\n", cJSON_GetArraySize(value));
}

int main(int argc, char **argv)
{
    static char text[1 << 20];
    size_t size = fread(text, 1, sizeof text - 1, stdin);
    text[size] = 0;
    cJSON *document = cJSON_ParseWithOpts(text, NULL, 1);
    const cJSON *value = find(document, argc > 1 ? argv[1] : "");
    if (value)
        print(value);
    cJSON_Delete(document);
    return value ? 0 : 1;
}
