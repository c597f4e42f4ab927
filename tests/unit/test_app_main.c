/* The program as a whole: its command line, what it says where, and its exit status. */
#include "output/version.h"
#include "support/program.h"

#include <signal.h>
#include <time.h>

#define COARSE "thick_cylinder --variant coarse_4mm"
#define SHORT COARSE " --set time.end='8 us'"

static void help_goes_to_stdout_and_succeeds(void **state)
{
  (void)state;
  static const char *const commands[] = {"sunder -h", "sunder help"};
  said help, other;
  succeed(&help, "sunder --help");
  assert_non_null(strstr(help.out, "sunder run SCENE [-o DIR]"));
  assert_non_null(strstr(help.out, "Exit status: 0 done, 1 bad input, 2 the run failed, 3 a file"));
  for (size_t k = 0; k < sizeof commands / sizeof *commands; ++k) {
    succeed(&other, commands[k]);
    assert_string_equal(other.out, help.out);
  }
}

static void help_for_a_command_is_about_that(void **state)
{
  (void)state;
  static const char *const ways[] = {"sunder help plot", "sunder plot DIR -h",
                                     "sunder plot --nonsense --help"};
  said s;
  for (size_t k = 0; k < sizeof ways / sizeof *ways; ++k) {
    succeed(&s, ways[k]);
    assert_ptr_equal(strstr(s.out, "  sunder plot DIR [--field NAME]"), s.out);
    assert_non_null(strstr(s.out, "level fragment; components as in stress.xx.\n"));
    assert_non_null(strstr(s.out, "\nExit status: 0 done,"));
    assert_null(strstr(s.out, "sunder run"));
  }
  succeed(&s, "sunder run --help");
  assert_non_null(strstr(s.out, "Damage laws: none variational critical_stretch at1\ncohesive."));
  refuse(
      &s, "sunder help fly", 1,
      "sunder: there is no command 'fly'; there are run, check, problems, plot, compare, help\n");
}

static void no_command_at_all_shows_the_help_and_fails(void **state)
{
  (void)state;
  said help, s;
  succeed(&help, "sunder --help");
  refuse(&s, "sunder", 1, help.out);
}

static void the_version_is_printed(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder --version");
  assert_string_equal(s.out, "sunder " SUNDER_VERSION "\n");
}

static void wrong_command_lines_say_what_would_be_right(void **state)
{
  (void)state;
  static const char *const cases[][2] = {
      {"fly", "there is no command 'fly'; there are run, check, problems, plot, compare, help"},
      {"--fly", "there is no command '--fly'; there are run, check, problems, plot, compare, help"},
      {"run", "sunder run needs a scene (see sunder --help)"},
      {"run a b", "sunder run takes a scene; 'b' is one too many"},
      {"run a --fly", "sunder run has no option '--fly'; it takes: -o --set --variant --threads "
                      "--resume --isa --quiet (see sunder --help)"},
      {"run a '-o '", "sunder run has no option '-o '; it takes: -o --set --variant --threads "
                      "--resume --isa --quiet (see sunder --help)"},
      {"check a -o b",
       "sunder check has no option '-o'; it takes: --set --variant (see sunder --help)"},
      {"run a -o", "option '-o' needs a value"},
      {"run a -o ''", "option '-o' needs a value"},
      {"run a --set=", "option '--set' needs a value"},
      {"run a --quiet=1", "option '--quiet' takes no value"},
      {"problems a b",
       "sunder problems takes the name of a problem or nothing; 'b' is one too many"},
      {"plot", "sunder plot needs the directory of a run (see sunder --help)"},
      {"compare a", "sunder compare needs the directories of two runs (see sunder --help)"},
      {"run thick_cylinder --threads 0", "--threads '0': give a whole number from 1 to 256"},
      {"run thick_cylinder --threads 2x", "--threads '2x': give a whole number from 1 to 256"},
      {"run thick_cylinder --isa sse",
       "instruction set 'sse' is unknown; known are avx512, avx2, baseline"},
      {"run thick_cylinder --set foo",
       "--set foo: write it as PATH=VALUE, like --set time.end=\"1 us\""},
      {"run thick_cylinder --set points.spacing=",
       "--set points.spacing: no value after '='; give one"},
      {"run thick_cylinder --set points.spacing=4us",
       "--set points.spacing:1: points.spacing: '4us' is a time, wanted a length, like 1 mm"}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    char command[300], text[600];
    said s;
    snprintf(command, sizeof command, "sunder %s", cases[k][0]);
    snprintf(text, sizeof text, "sunder: %s\n", cases[k][1]);
    refuse(&s, command, 1, text);
  }
}

static void an_unknown_variant_names_those_there_are(void **state)
{
  (void)state;
  said s;
  shell(&s, "sunder check thick_cylinder --variant coarse");
  assert_int_equal(s.code, 1);
  assert_non_null(strstr(s.err, "scene.yaml: unknown variant 'coarse'; variants of this scene: "));
  assert_non_null(strstr(s.err, ", coarse_1mm, coarse_2mm, coarse_4mm\n"));
}

static void problems_are_listed_one_a_line(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder problems");
  assert_non_null(
      strstr(s.out, "thick_cylinder           Thick cylinder under internal pressure\n"));
  succeed(&s, "sunder problems thick_cylinder");
  assert_non_null(strstr(s.out, "Thick cylinder under internal pressure\nscene               "));
  assert_non_null(strstr(s.out, "/scene.yaml\nvariants            "));
  assert_non_null(strstr(s.out, ", coarse_1mm, coarse_2mm, coarse_4mm"));
  succeed(&s, "mkdir -p mine/bar mine/empty mine/wrong && "
              "cp '" SUNDER_SOURCE_DIR "/tests/scenes/good/bar.yaml' mine/bar/scene.yaml && "
              "echo 'title: [' > mine/wrong/scene.yaml && mkdir -p elsewhere && cd elsewhere && "
              "SUNDER_PROBLEMS=../mine sunder problems");
  assert_non_null(
      strstr(s.out, "bar                      bar\nwrong                    cannot be read: "));
}

/* From the paper: 196,556 points; bonds and step are this lattice's own. */
static void check_tells_what_would_run_and_runs_nothing(void **state)
{
  (void)state;
  static const char *const parts[] = {
      "Thick cylinder under internal pressure\n",
      "model               bond_based, plane_stress, damage variational, integrator leapfrog\n",
      "kernels             ",
      ", double precision, ",
      "points              196556, spacing 0.5 mm, horizon 1.505 mm\n",
      "bonds               5449424 directed, 2724712 pairs: 2724712 in 12874 runs, 0 loose\n",
      "body                area of the points 0.04914 m^2, of the shape 0.04914 m^2 (+0.0 %)",
      "; mass 385.7 kg\n",
      "load                pressure on inner: acts on 920 points\n",
      "stable step         183.2 ns; step 100 ns (0.546 of it), 1000 steps to 100 us\n",
      "memory              ",
      " MB damage history\n",
      "material            body: E 210 GPa, density 7850 kg/m^3, E scattered by 5 %\n",
      "  waves             longitudinal 5486 m/s, shear 3167 m/s, Rayleigh 2954 m/s\n",
      "  poisson_used      0.3333, the law's own (given 0.3)\n",
      "  micromodulus      ",
      "  c11               ",
      "  stretch s_c       ",
      "  separation        10000 J/m^2 = toughness x 0.5; over directions ",
      "onset               at a point's damage of 0.5\n",
      "skipped\n",
      "  third component: 2-D\n",
      "defaults\n",
      "  points.align = point\n",
      "  output.directory = out/thick_cylinder\n"};
  said s;
  succeed(&s, "mkdir -p checked && cd checked && sunder check thick_cylinder");
  const char *from = s.out;
  for (size_t k = 0; k < sizeof parts / sizeof *parts; ++k) {
    const char *found = strstr(from, parts[k]);
    if (!found) fail_msg("'%s' is not (or not in its order) in\n%s", parts[k], s.out);
    from = found + strlen(parts[k]);
  }
  assert_int_equal(rmdir("checked"), 0); /* nothing was written there */
}

static void check_tells_the_strength_of_laws_that_soften(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder check cohesive_bar");
  assert_non_null(strstr(s.out, "  largest horizon   239.2 mm for this strength and toughness\n"
                                "  strength          2.702 MPa (1.023 E s_e), 2.859 MPa (1.082 E "
                                "s_e), 2.696 MPa (1.020 E s_e), 2.581 MPa (0.977 E s_e) at 0, 15, "
                                "30, 45 degrees to the lattice\n"));
  succeed(&s, "sunder check cohesive_bar --set damage.law=at1");
  assert_non_null(strstr(s.out, "(0.723 E s_c)"));
  succeed(&s, "sunder check cohesive_bar --set damage.law=variational");
  assert_non_null(strstr(s.out, "(0.407 E s_c)"));
}

#define BOX                                                                                        \
  "sunder check thick_cylinder --variant coarse_4mm --set points.shape='{box: {from: [0, 0], to: " \
  "[100 mm, 40 mm]}}' --set points.spacing='5 mm' --set loads='[{traction: {on: top, value: [0, "  \
  "1 Pa]}}]' --set supports='[{name: foot, on: bottom, displacement: {y: 0}}]' --set "             \
  "output.ring=false "

/* 21 x 9 points of 25 mm^2 in 40 cm^2; with cells inside it 20 x 8 points. */
static void check_compares_the_points_with_the_shape_and_says_what_holds_them(void **state)
{
  (void)state;
  said s;
  succeed(&s, BOX);
  assert_non_null(strstr(s.out,
                         "body                area of the points 0.004725 m^2, of the shape 0.004 "
                         "m^2 (+18.1 %); mass 37.09 kg\n"
                         "hint                points.align: cell puts the edges of cells, not "
                         "points, on the shape's; or take a finer spacing\n"
                         "support             foot on bottom: 42 points (y)\n"
                         "load                traction on top: acts on 21 points\n"));
  succeed(&s, BOX "--set points.align=cell");
  assert_non_null(strstr(s.out,
                         "body                area of the points 0.004 m^2, of the shape 0.004 m^2 "
                         "(+0.0 %); mass 31.4 kg\n"
                         "support             foot on bottom: 20 points (y)\n"
                         "load                traction on top: acts on 20 points\n"));
  succeed(&s, BOX "--set points.align=cell --set time.step=auto --set horizon='1 spacing'");
  assert_non_null(strstr(
      s.out,
      "warning             the body has no shear stiffness: a horizon of 1 times the spacing "
      "holds bonds along the axes of the lattice only; give at least 1.5 spacings, "
      "3.015 as a rule (horizon)\n"));
  succeed(&s, BOX "--set points.align=cell --set time.step=auto --set horizon='1.5 spacing'");
  assert_null(strstr(s.out, "shear stiffness"));
}

static void check_warns_of_units_that_are_likely_wrong(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder check " COARSE " --set time.step=auto --set material.young=210");
  assert_non_null(strstr(s.out, " is longer than the run (0.0001 s); are the units of time.end, "
                                "young and density right?\n"));
  succeed(&s, "sunder check " COARSE " --set time.step=auto --set time.end=80");
  assert_non_null(strstr(s.out, " steps; is the unit of time.end (80 s) right?\n"));
  succeed(&s, "sunder check " COARSE " --set time.safety=0.5 --set damage.law=critical_stretch");
  assert_null(strstr(s.out, "warning"));
  assert_non_null(strstr(s.out, "\nwithout effect\n  damage.ell: the law critical_stretch does not "
                                "use it\ndefaults\n"));
}

static void check_refuses_what_run_would_refuse(void **state)
{
  (void)state;
  static const char *const sets[] = {
      "figures='{speed: {low: 1}}'",
      "time.step='20 us'",
      "output.probes='[{name: p, at: [0.1, 0], fields: [fragment]}]'",
      "horizon='3 mm'",
      "supports='[{on: {disc: {radius: 1 mm}}, displacement: {x: 0}}]'",
      "output.cracks='{tips: {notch: {start: [0, 0]}}}'",
      "damage.law=none --set time='{integrator: static}'",
      "damage.law=none --set time='{integrator: static}' --set supports='[{on: outer, "
      "displacement: "
      "{x: 0}}]'",
      "time='{integrator: static}'"};
  for (size_t k = 0; k < sizeof sets / sizeof *sets; ++k) {
    char command[300];
    said checked, ran;
    snprintf(command, sizeof command, "sunder check " COARSE " --set %s", sets[k]);
    shell(&checked, command);
    snprintf(command, sizeof command, "sunder run " COARSE " -o unwanted --quiet --set %s",
             sets[k]);
    shell(&ran, command);
    assert_int_equal(checked.code, 1);
    assert_int_equal(ran.code, 1);
    assert_string_equal(checked.out, "");
    assert_string_equal(checked.err, ran.err);
    assert_int_equal(strncmp(checked.err, "sunder: ", 8), 0);
  }
}

static void check_refuses_a_directory_that_run_could_not_make(void **state)
{
  (void)state;
  said s;
  refuse(&s, "sunder check " COARSE " --set output.directory=/proc/nope", 3,
         "sunder: cannot make the directory /proc/nope: No such file or directory\n");
  refuse(&s, "touch taken && sunder check " COARSE " --set output.directory=taken", 3,
         "sunder: cannot use taken as the run's directory: it is a file\n");
  refuse(&s, "sunder check nom_poisson --set output.directory=/proc/nope", 3,
         "sunder: cannot make the directory /proc/nope: No such file or directory\n");
  succeed(&s, "sunder check " COARSE " --set output.directory=new/folder/");
  assert_false(exists("new"));
}

static void results_go_to_stdout_and_progress_to_stderr(void **state)
{
  (void)state;
  said s;
  shell(&s, "sunder run " SHORT " -o loud");
  assert_int_equal(s.code, 0);
  assert_non_null(
      strstr(s.out, "Thick cylinder, 4 mm: 3068 points, 79112 bonds, 10 steps to 8 us"));
  assert_non_null(strstr(s.out, "\nonset of damage     never\n"));
  assert_non_null(strstr(s.out, "\nresults             loud\n"));
  assert_null(strstr(s.out, "steps/s"));
  assert_non_null(strstr(s.err, "100 %, 8.00 us of 8.00 us, step 10/10"));
  assert_null(strchr(s.err, '\r')); /* no bar where nobody watches */
  assert_null(strstr(s.err, "replaced"));
  assert_non_null(strstr(s.out, "\n  accepted ranges are of the scene's own settings, which --set "
                                "changed\nresults "));
  shell(&s, "sunder run " SHORT " -o loud --set material.young='200 GPa'");
  assert_int_equal(s.code, 0);
  assert_non_null(strstr(s.err, "sunder: the results of another scene in loud are replaced\n"));
  succeed(&s, "sunder run " SHORT " -o loud --quiet");
}

static void a_directory_is_named_after_scene_and_variant(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder run " SHORT " --quiet");
  assert_true(exists("out/thick_cylinder-coarse_4mm/summary.json"));
  succeed(&s, "sunder check thick_cylinder --variant coarse_4mm");
  succeed(&s, "cp '" SUNDER_SOURCE_DIR "/tests/scenes/good/bar.yaml' . && "
              "sunder run bar.yaml --quiet --set points.spacing='1 cm'");
  assert_true(exists("out/bar/summary.json"));
  succeed(&s, "sunder run bar.yaml --quiet --set points.spacing='1 cm' --set output.directory=a/b");
  assert_true(exists("a/b/summary.json"));
  succeed(&s, "sunder run bar.yaml --quiet --set points.spacing='1 cm' --set output.directory=c "
              "-o d/e/f");
  assert_true(exists("d/e/f/summary.json"));
  assert_false(exists("c"));
}

static void a_folder_with_a_scene_is_a_scene(void **state)
{
  (void)state;
  said s;
  succeed(&s, "mkdir -p rod && cp '" SUNDER_SOURCE_DIR "/tests/scenes/good/bar.yaml' "
              "rod/scene.yaml && sunder run rod/ --quiet --set=points.spacing=1cm");
  assert_true(exists("out/rod/summary.json"));
}

static void later_overrides_go_before_earlier_and_all_before_variant_and_scene(void **state)
{
  (void)state;
  static char used[20000];
  said s;
  succeed(&s, "sunder run " COARSE " -o order --quiet --set time.end='8 us' --set time.end='4 us' "
              "--set time.step='0.5 us' --set loads.0.pressure.value='1 MPa'");
  assert_non_null(strstr(s.out, " 8 steps to 4 us\n"));
  read_whole("order/used.yaml", used, sizeof used);
  assert_non_null(strstr(used, "  spacing: 4 mm\n")); /* the variant's, not the scene's */
  assert_non_null(strstr(used, "  step: 0.5 us\n"));  /* --set, not the variant's */
  assert_non_null(strstr(used, "pressure: {on: inner, value: 1 MPa,"));
  assert_non_null(strstr(used, "  young: 210 GPa\n")); /* the scene's */
}

static void a_directory_in_use_is_refused_and_a_dead_lock_is_not(void **state)
{
  (void)state;
  char text[300];
  said s;
  const pid_t pid = start("sunder run " COARSE " -o live --quiet --set time.end='1 s'");
  for (int wait = 0; wait < 3000 && !exists("live/history.csv"); ++wait)
    nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
  snprintf(text, sizeof text,
           "sunder: the directory live is in use by process %ld; wait until it is done or give "
           "another directory with -o\n",
           (long)pid);
  refuse(&s, "sunder run " SHORT " -o live --quiet", 1, text);
  assert_true(exists("live/history.csv"));
  assert_int_equal(kill(pid, SIGKILL), 0);
  assert_int_equal(waitpid(pid, NULL, 0), pid);
  assert_true(exists("live/.lock"));
  succeed(&s, "sunder run " SHORT " -o live --quiet");
  assert_true(exists("live/summary.json"));
  assert_false(exists("live/.lock"));
}

static void a_full_stdout_is_an_io_error(void **state)
{
  (void)state;
  said s;
  refuse(&s, "sunder --help >/dev/full", 3, "sunder: standard output: No space left on device\n");
  refuse(&s, "sunder --version >/dev/full", 3,
         "sunder: standard output: No space left on device\n");
  refuse(&s, "sunder check " COARSE " >/dev/full", 3,
         "sunder: standard output: No space left on device\n");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(help_goes_to_stdout_and_succeeds),
      cmocka_unit_test(help_for_a_command_is_about_that),
      cmocka_unit_test(no_command_at_all_shows_the_help_and_fails),
      cmocka_unit_test(the_version_is_printed),
      cmocka_unit_test(wrong_command_lines_say_what_would_be_right),
      cmocka_unit_test(an_unknown_variant_names_those_there_are),
      cmocka_unit_test(problems_are_listed_one_a_line),
      cmocka_unit_test(check_tells_what_would_run_and_runs_nothing),
      cmocka_unit_test(check_tells_the_strength_of_laws_that_soften),
      cmocka_unit_test(check_compares_the_points_with_the_shape_and_says_what_holds_them),
      cmocka_unit_test(check_warns_of_units_that_are_likely_wrong),
      cmocka_unit_test(check_refuses_what_run_would_refuse),
      cmocka_unit_test(check_refuses_a_directory_that_run_could_not_make),
      cmocka_unit_test(results_go_to_stdout_and_progress_to_stderr),
      cmocka_unit_test(a_directory_is_named_after_scene_and_variant),
      cmocka_unit_test(a_folder_with_a_scene_is_a_scene),
      cmocka_unit_test(later_overrides_go_before_earlier_and_all_before_variant_and_scene),
      cmocka_unit_test(a_directory_in_use_is_refused_and_a_dead_lock_is_not),
      cmocka_unit_test(a_full_stdout_is_an_io_error),
  };
  return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
