/* The program: reads the command line and calls one function for each command. */
#include "app/check.h"
#include "app/compare.h"
#include "app/find_scene.h"
#include "app/plot.h"
#include "app/plot_view.h"
#include "app/run.h"
#include "base/parallel.h"
#include "mechanics/bond_body.h"
#include "output/version.h"
#include "scene/expression.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST_SETS = 256 };

static const char head[] = "Sunder: fracture by dual-horizon peridynamics.\n\n";

static const char run_help[] =
    "  sunder run SCENE [-o DIR] [--set KEY=VALUE]... [--variant NAME] [--threads N]\n"
    "                   [--resume CHECKPOINT] [--isa avx512|avx2|baseline] [--quiet]\n"
    "      run a scene; results go to DIR (default out/SCENE[-NAME]; a resumed run goes on in\n"
    "      the directory of its checkpoint)\n";
static const char check_help[] =
    "  sunder check SCENE [--set KEY=VALUE]... [--variant NAME]\n"
    "      what would run: variants, points, size and mass, bonds, stable step, memory,\n"
    "      constants, what has no effect, defaults\n";
static const char problems_help[] =
    "  sunder problems [NAME]\n"
    "      the scenes that come with Sunder, one line each; of one: its file and variants\n";
static const char plot_help[] =
    "  sunder plot DIR [--field NAME] [--time T] [--deformed FACTOR] [--slice PLANE]\n"
    "              [--movie] [-o FILE]\n"
    "      pictures of a run: a field (damage by default), the energies over time, and probes\n"
    "      and reactions where the scene has some; T puts the time into the field's file name;\n"
    "      T may carry a unit, as in --time \"45 us\"; --deformed moves points by FACTOR times\n"
    "      their displacement; a solid body shows a slice besides, as in --slice \"z=2 mm\"\n"
    "      (none: no slice); --movie draws all frames\n";
static const char compare_help[] = "  sunder compare DIR_A DIR_B [-o FILE.png]\n"
                                   "      two runs side by side: a table and a picture\n";
static const char other_help[] = "  sunder help [COMMAND] | --help | --version\n";

static const char scene_help[] =
    "SCENE is a YAML file or the name of a folder in problems/. docs/scene.md lists every key.\n"
    "KEY=VALUE overrides a key of the scene, as in --set points.spacing=\"1 mm\".\n";
static const char words_help[] =
    "Models: bond_based ordinary nonordinary. Damage laws: none variational critical_stretch at1\n"
    "cohesive. Integrators: leapfrog static cvode ida energy_momentum.\n";
static const char fields_help[] =
    "Fields (output.fields of the scene): displacement velocity acceleration damage\n"
    "energy_density dissipated force reaction stress strain dilatation material horizon spacing\n"
    "level fragment; components as in stress.xx.\n";
static const char status_help[] =
    "Exit status: 0 done, 1 bad input, 2 the run failed, 3 a file could not be read or written,\n"
    "4 stopped by SIGINT or SIGTERM after writing DIR/checkpoint.h5.\n";

/* What the command line said. */
typedef struct {
  const char *arguments[2]; /* SCENE or directories */
  int argument_count;
  const char *output, *variant, *resume, *field, *time, *threads, *isa, *deformed, *slice;
  const char *sets[MOST_SETS];
  int set_count, quiet, movie;
} command_line;

typedef struct {
  const char *name;
  int least, arguments; /* how many it needs and takes */
  const char *options;  /* the options it knows, each between blanks */
  const char *wants;    /* what to give, for the message */
  sdr_status (*call)(const command_line *line);
  const char *help, *words; /* its lines, and of the words in them; "": none */
} command_entry;

/* ---- reading the command line ---------------------------------------------------------------- */

/* Where the value of an option goes; NULL if it is no option with a value. */
static const char **value_of(command_line *line, const char *option)
{
  if (strcmp(option, "-o") == 0) return &line->output;
  if (strcmp(option, "--variant") == 0) return &line->variant;
  if (strcmp(option, "--resume") == 0) return &line->resume;
  if (strcmp(option, "--field") == 0) return &line->field;
  if (strcmp(option, "--time") == 0) return &line->time;
  if (strcmp(option, "--threads") == 0) return &line->threads;
  if (strcmp(option, "--isa") == 0) return &line->isa;
  if (strcmp(option, "--deformed") == 0) return &line->deformed;
  if (strcmp(option, "--slice") == 0) return &line->slice;
  if (strcmp(option, "--set") == 0 && line->set_count < MOST_SETS)
    return &line->sets[line->set_count];
  return NULL;
}

static int knows(const command_entry *command, const char *option)
{
  char padded[64];
  snprintf(padded, sizeof padded, " %s ", option);
  if (strchr(option, ' ')) return 0;
  return strstr(command->options, padded) != NULL;
}

static sdr_status read_option(const command_entry *command, int count, char **words, int *k,
                              command_line *line)
{
  const char *word = words[*k], *given = strncmp(word, "--", 2) == 0 ? strchr(word, '=') : NULL;
  char option[48];
  snprintf(option, sizeof option, "%.*s", given ? (int)(given - word) : (int)sizeof option, word);
  if (!knows(command, option))
    return sdr_fail(SDR_BAD_INPUT, "sunder %s has no option '%s'; it takes:%s(see sunder --help)",
                    command->name, option, command->options);
  if (strcmp(word, "--quiet") == 0) {
    line->quiet = 1;
    return SDR_OK;
  }
  if (strcmp(word, "--movie") == 0) {
    line->movie = 1;
    return SDR_OK;
  }
  const char **value = value_of(line, option);
  if (!value && strcmp(option, "--set") == 0)
    return sdr_fail(SDR_BAD_INPUT, "more than %d --set options", (int)MOST_SETS);
  if (!value) return sdr_fail(SDR_BAD_INPUT, "option '%s' takes no value", option);
  const char *text = given ? given + 1 : *k + 1 < count ? words[++*k] : "";
  if (!*text) return sdr_fail(SDR_BAD_INPUT, "option '%s' needs a value", option);
  *value = text;
  if (strcmp(option, "--set") == 0) ++line->set_count;
  return SDR_OK;
}

static sdr_status read_line(const command_entry *command, int count, char **words,
                            command_line *line)
{
  for (int k = 0; k < count; ++k) {
    if (words[k][0] == '-' && words[k][1] != '\0') {
      SDR_TRY(read_option(command, count, words, &k, line));
    } else if (line->argument_count < command->arguments) {
      line->arguments[line->argument_count++] = words[k];
    } else {
      return sdr_fail(SDR_BAD_INPUT, "sunder %s takes %s; '%s' is one too many", command->name,
                      command->wants, words[k]);
    }
  }
  if (line->argument_count < command->least)
    return sdr_fail(SDR_BAD_INPUT, "sunder %s needs %s (see sunder --help)", command->name,
                    command->wants);
  return SDR_OK;
}

static sdr_status read_threads(const char *text, int *threads)
{
  char *end;
  if (!text) return SDR_OK;
  errno = 0;
  const long value = strtol(text, &end, 10);
  if (end == text || *end != '\0' || errno != 0 || value < 1 || value > 256)
    return sdr_fail(SDR_BAD_INPUT, "--threads '%s': give a whole number from 1 to 256", text);
  *threads = (int)value;
  return SDR_OK;
}

/* A number that may carry a unit, the value of `option`. */
static sdr_status read_quantity(const char *option, const char *text, sdr_unit unit, double *out)
{
  static const double nowhere[3] = {0.0};
  sdr_expression *expression = NULL;
  if (sdr_expression_create(text, unit, NULL, NULL, &expression) != SDR_OK)
    return sdr_fail(SDR_BAD_INPUT, "%s '%s': column %s", option, text, sdr_error_message());
  const sdr_status status = sdr_expression_value(expression, nowhere, 0.0, out);
  sdr_expression_destroy(&expression);
  return status;
}

static sdr_status read_time(const char *text, double *time)
{
  return text ? read_quantity("--time", text, (sdr_unit){.s = 1}, time) : SDR_OK;
}

/* "z=2 mm", "none". */
static sdr_status read_slice(const char *text, sdr_plot_options *options)
{
  if (!text) return SDR_OK;
  options->slice_axis = SDR_SLICE_NONE;
  if (strcmp(text, "none") == 0) return SDR_OK;
  if (text[0] < 'x' || text[0] > 'z' || text[1] != '=')
    return sdr_fail(SDR_BAD_INPUT, "--slice '%s': give a plane, like z=2 mm, or none", text);
  options->slice_axis = text[0] - 'x' + 1;
  return read_quantity("--slice", text + 2, (sdr_unit){.m = 1}, &options->slice_at);
}

/* ---- commands -------------------------------------------------------------------------------- */

static sdr_status run(const command_line *line)
{
  char path[SDR_SCENE_PATH];
  sdr_run_options options = {.variant = line->variant,
                             .directory = line->output,
                             .resume = line->resume,
                             .set_count = line->set_count,
                             .sets = line->sets,
                             .quiet = line->quiet,
                             .stoppable = 1,
                             .scene = path};
  SDR_TRY(read_threads(line->threads, &options.threads));
  if (line->isa) SDR_TRY(sdr_isa_limit(line->isa));
  SDR_TRY(sdr_find_scene(line->arguments[0], path));
  return sdr_run(&options, stdout);
}

static sdr_status check(const command_line *line)
{
  char path[SDR_SCENE_PATH];
  SDR_TRY(sdr_find_scene(line->arguments[0], path));
  return sdr_check(path, line->variant, line->set_count, line->sets, stdout);
}

static sdr_status problems(const command_line *line)
{
  return line->argument_count > 0 ? sdr_tell_problem(line->arguments[0], stdout)
                                  : sdr_list_problems(stdout);
}

static sdr_status plot(const command_line *line)
{
  sdr_plot_options options = {.directory = line->arguments[0],
                              .field = line->field,
                              .time = (double)NAN,
                              .movie = line->movie,
                              .png = line->output};
  SDR_TRY(read_time(line->time, &options.time));
  SDR_TRY(read_slice(line->slice, &options));
  if (line->deformed)
    SDR_TRY(read_quantity("--deformed", line->deformed, (sdr_unit){0}, &options.deformed));
  return sdr_plot(&options, stdout);
}

static sdr_status compare(const command_line *line)
{
  return sdr_compare(line->arguments[0], line->arguments[1], line->output, stdout);
}

static const command_entry commands[] = {
    {"run", 1, 1, " -o --set --variant --threads --resume --isa --quiet ", "a scene", run, run_help,
     words_help},
    {"check", 1, 1, " --set --variant ", "a scene", check, check_help, words_help},
    {"problems", 0, 1, " ", "the name of a problem or nothing", problems, problems_help, ""},
    {"plot", 1, 1, " --field --time --deformed --slice --movie -o ", "the directory of a run", plot,
     plot_help, fields_help},
    {"compare", 2, 2, " -o ", "the directories of two runs", compare, compare_help, ""}};
enum { COMMANDS = sizeof commands / sizeof *commands };

/* ---- help ------------------------------------------------------------------------------------ */

static void print_help(FILE *out)
{
  fputs(head, out);
  for (size_t k = 0; k < COMMANDS; ++k) fputs(commands[k].help, out);
  fprintf(out, "%s\n%s%s%s%s", other_help, scene_help, words_help, fields_help, status_help);
}

static void print_command_help(const command_entry *command, FILE *out)
{
  const int takes_scene = strcmp(command->wants, "a scene") == 0;
  fprintf(out, "%s\n%s%s%s", command->help, takes_scene ? scene_help : "", command->words,
          status_help);
}

static const command_entry *find_command(const char *name)
{
  for (size_t k = 0; k < COMMANDS; ++k)
    if (strcmp(name, commands[k].name) == 0) return &commands[k];
  return NULL;
}

static sdr_status fail_unknown(const char *name)
{
  return sdr_fail(SDR_BAD_INPUT,
                  "there is no command '%s'; there are run, check, problems, plot, compare, help",
                  name);
}

static int is_help(const char *word)
{
  return strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0;
}

static sdr_status help(int count, char **words)
{
  const command_entry *command = count > 2 ? find_command(words[2]) : NULL;
  if (count > 2 && !command) return fail_unknown(words[2]);
  if (command)
    print_command_help(command, stdout);
  else
    print_help(stdout);
  return SDR_OK;
}

static sdr_status call_command(int count, char **words)
{
  command_line line = {0};
  if (is_help(words[1]) || strcmp(words[1], "help") == 0) return help(count, words);
  if (strcmp(words[1], "--version") == 0) {
    printf("sunder %s\n", SUNDER_VERSION);
    return SDR_OK;
  }
  const command_entry *command = find_command(words[1]);
  if (!command) return fail_unknown(words[1]);
  for (int w = 2; w < count; ++w)
    if (is_help(words[w])) {
      print_command_help(command, stdout);
      return SDR_OK;
    }
  SDR_TRY(read_line(command, count - 2, words + 2, &line));
  return command->call(&line);
}

/* Idle threads that spin slow a shared machine down; libgomp reads this when it is loaded, so the
   program starts itself again once. */
static void limit_spinning(char **words)
{
  if (getenv("GOMP_SPINCOUNT") || getenv("OMP_WAIT_POLICY")) return;
  setenv("GOMP_SPINCOUNT", "1000", 1);
  execv("/proc/self/exe", words); /* where that fails the program just goes on */
}

int main(int count, char **words)
{
  if (count < 2) {
    print_help(stderr);
    return SDR_BAD_INPUT;
  }
  limit_spinning(words);
  sdr_status status = call_command(count, words);
  if (status == SDR_OK && fflush(stdout) != 0)
    status = sdr_fail(SDR_IO_ERROR, "standard output: %s", strerror(errno));
  if (status != SDR_OK) fprintf(stderr, "sunder: %s\n", sdr_error_message());
  return (int)status;
}
