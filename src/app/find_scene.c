#include "app/find_scene.h"

#include "base/memory.h"
#include "scene/reader.h"
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

static int by_name(const void *a, const void *b)
{
  return strcmp(*(char *const *)a, *(char *const *)b);
}

enum { MOST_PROBLEMS = 1000 };

/* The problems' names in order, and their folder; how many there are, -1: no folder. The caller
   frees them. */
static int find_names(const char **folder, char *names[MOST_PROBLEMS])
{
  char path[SDR_SCENE_PATH];
  int count = 0;
  DIR *listing = open_problems(folder);
  if (!listing) return -1;
  for (const struct dirent *entry; (entry = readdir(listing)) && count < MOST_PROBLEMS;)
    if (is_problem(*folder, entry, path) && (names[count] = sdr_strdup(entry->d_name))) ++count;
  closedir(listing);
  qsort(names, (size_t)count, sizeof *names, by_name);
  return count;
}

/* A mistyped name is wrong input, a file that is not there is a matter of files. */
static sdr_status fail_unknown(const char *name)
{
  const char *folder, *nearest;
  char *names[MOST_PROBLEMS], listed[2048] = "", hint[SDR_SCENE_PATH + 32] = "", file[300];
  const int count = find_names(&folder, names), is_name = *name && !strchr(name, '/');
  size_t used = 0;
  for (int k = 0; k < count && used < sizeof listed; ++k)
    used += (size_t)snprintf(listed + used, sizeof listed - used, "%s%s",
                             k ? ", " : "; problems: ", names[k]);
  snprintf(file, sizeof file, "%.250s.yaml", name);
  nearest = sdr_read_nearest(name, (const char *const *)names, count > 0 ? count : 0);
  if (is_name && is_file(file))
    snprintf(hint, sizeof hint, " (did you mean the file '%s'?)", file);
  else if (is_name && nearest)
    snprintf(hint, sizeof hint, " (did you mean '%s'?)", nearest);
  const sdr_status status = is_name && !strstr(name, ".yaml") ? SDR_BAD_INPUT : SDR_IO_ERROR;
  sdr_fail(status, "there is no scene '%s': neither a file nor a problem%s%s", name, hint, listed);
  for (int k = 0; k < count; ++k) sdr_free(names[k]);
  return status;
}

sdr_status sdr_find_scene(const char *name, char path[SDR_SCENE_PATH])
{
  if (strchr(name, '/') == NULL && strstr(name, ".yaml") == NULL) {
    const char *folder;
    for (int k = 0; (folder = problems_folder(k)) != NULL; ++k) {
      const int length = snprintf(path, SDR_SCENE_PATH, "%s/%s/scene.yaml", folder, name);
      if (length < SDR_SCENE_PATH && is_file(path)) return SDR_OK;
    }
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
  return fail_unknown(name);
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

sdr_status sdr_tell_problem(const char *name, FILE *out)
{
  char path[SDR_SCENE_PATH];
  sdr_scene *scene = NULL;
  SDR_TRY(sdr_find_scene(name, path));
  SDR_TRY(sdr_scene_load(path, NULL, 0, NULL, &scene));
  fprintf(out, "%s\nscene               %s\nvariants            %s\n", scene->title, path,
          *scene->variants ? scene->variants : "none");
  sdr_scene_destroy(&scene);
  return SDR_OK;
}

sdr_status sdr_list_problems(FILE *out)
{
  const char *folder;
  char *names[MOST_PROBLEMS];
  const int count = find_names(&folder, names);
  if (count < 0)
    return sdr_fail(SDR_IO_ERROR, "there is no folder 'problems' here; go to where Sunder lies, or "
                                  "set SUNDER_PROBLEMS to it");
  for (int k = 0; k < count; ++k) {
    print_problem(names[k], folder, out);
    sdr_free(names[k]);
  }
  return SDR_OK;
}
