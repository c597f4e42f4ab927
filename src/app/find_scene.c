#include "app/find_scene.h"

#include "base/memory.h"
#include "scene/scene.h"

#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#ifndef SUNDER_PROBLEMS_DIR
#define SUNDER_PROBLEMS_DIR "problems"
#endif

static int is_file(const char *path)
{
  struct stat info;
  return stat(path, &info) == 0 && !S_ISDIR(info.st_mode);
}

/* Where an installed program has its problems: share/sunder beside its bin. */
static const char *installed_folder(void)
{
  static char path[SDR_SCENE_PATH];
  static const char beside[] = "/../share/sunder/problems";
  const ssize_t length = readlink("/proc/self/exe", path, sizeof path - sizeof beside);
  if (length <= 0) return "problems";
  path[length] = '\0';
  char *slash = strrchr(path, '/');
  memcpy(slash ? slash : path, beside, sizeof beside);
  return path;
}

/* The folders that problems are looked for in; NULL past the last. */
static const char *problems_folder(int k)
{
  const char *own = getenv("SUNDER_PROBLEMS");
  switch (k) {
  case 0:
    return "problems";
  case 1:
    return own ? own : "problems";
  case 2:
    return installed_folder();
  case 3:
    return SUNDER_PROBLEMS_DIR;
  default:
    return NULL;
  }
}

/* The first of them that exists. */
static DIR *open_problems(const char **folder)
{
  for (int k = 0; (*folder = problems_folder(k)) != NULL; ++k) {
    DIR *listing = opendir(*folder);
    if (listing) return listing;
  }
  return NULL;
}

static int is_problem(const char *folder, const struct dirent *entry, char path[SDR_SCENE_PATH])
{
  if (entry->d_name[0] == '.') return 0;
  const int length = snprintf(path, SDR_SCENE_PATH, "%s/%s/scene.yaml", folder, entry->d_name);
  return length < SDR_SCENE_PATH && is_file(path);
}

static void list_names(char *text, size_t size)
{
  const char *folder;
  char path[SDR_SCENE_PATH];
  DIR *listing = open_problems(&folder);
  text[0] = '\0';
  if (!listing) return;
  for (const struct dirent *entry; (entry = readdir(listing));)
    if (is_problem(folder, entry, path)) {
      strncat(text, text[0] ? ", " : "; problems: ", size - strlen(text) - 1);
      strncat(text, entry->d_name, size - strlen(text) - 1);
    }
  closedir(listing);
}

sdr_status sdr_find_scene(const char *name, char path[SDR_SCENE_PATH])
{
  if (strchr(name, '/') == NULL && strstr(name, ".yaml") == NULL)
    for (int k = 0; problems_folder(k); ++k) {
      const int length =
          snprintf(path, SDR_SCENE_PATH, "%s/%s/scene.yaml", problems_folder(k), name);
      if (length < SDR_SCENE_PATH && is_file(path)) return SDR_OK;
    }
  struct stat info;
  int length = snprintf(path, SDR_SCENE_PATH, "%s/scene.yaml", name);
  if (*name && length < SDR_SCENE_PATH && is_file(path)) return SDR_OK;
  if (stat(name, &info) == 0) { /* a folder or an unreadable file is the reader's to refuse */
    length = snprintf(path, SDR_SCENE_PATH, "%s", name);
    if (length < SDR_SCENE_PATH) return SDR_OK;
    return sdr_fail(SDR_BAD_INPUT, "the path of the scene is longer than %d characters",
                    (int)SDR_SCENE_PATH - 1);
  }
  char names[2048];
  list_names(names, sizeof names);
  return sdr_fail(SDR_IO_ERROR, "there is no scene '%s': neither a file nor a problem%s", name,
                  names);
}

static int by_name(const void *a, const void *b)
{
  return strcmp(*(char *const *)a, *(char *const *)b);
}

static void print_problem(const char *name, const char *folder, FILE *out)
{
  char path[SDR_SCENE_PATH];
  sdr_scene *scene = NULL;
  snprintf(path, sizeof path, "%s/%s/scene.yaml", folder, name);
  if (sdr_scene_load(path, NULL, 0, NULL, &scene) == SDR_OK)
    fprintf(out, "%-24s %s\n", name, scene->title);
  else
    fprintf(out, "%-24s cannot be read: %s\n", name, sdr_error_message());
  sdr_scene_destroy(&scene);
}

sdr_status sdr_list_problems(FILE *out)
{
  enum { MOST = 1000 };
  const char *folder;
  char path[SDR_SCENE_PATH];
  DIR *listing = open_problems(&folder);
  if (!listing)
    return sdr_fail(SDR_IO_ERROR, "there is no folder 'problems' here; go to where Sunder lies, or "
                                  "set SUNDER_PROBLEMS to it");
  char **names = sdr_alloc(MOST, sizeof *names);
  size_t count = 0;
  for (const struct dirent *entry; names && (entry = readdir(listing)) && count < MOST;)
    if (is_problem(folder, entry, path) && (names[count] = sdr_strdup(entry->d_name))) ++count;
  closedir(listing);
  if (!names) return SDR_RUN_FAILED;
  qsort(names, count, sizeof *names, by_name);
  for (size_t k = 0; k < count; ++k) {
    print_problem(names[k], folder, out);
    sdr_free(names[k]);
  }
  sdr_free(names);
  return SDR_OK;
}
