// tessera: renders scenes here or on a farm.
#include <CLI/CLI.hpp>

#include <exception>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "wire/version.h"

int main(int argc, char** argv) {
  using namespace tessera::client;
  Interrupt interrupt;
  CLI::App app{"Renders scenes, in this process or on a farm of workers.", "tessera"};
  app.set_version_flag("--version", tessera::wire::build_version());
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 2 usage, 3 bad scene, 4 cannot reach or not allowed, 5 job failed, 6 incomplete, "
      "7 image with marked holes (tessera retry), 130 interrupted.");

  Action action;
  add_render_command(app, action);
  add_submit_command(app, action);
  add_jobs_command(app, action);
  add_job_command(app, action);
  add_watch_command(app, action);
  add_fetch_command(app, action);
  add_cancel_command(app, action);
  add_retry_command(app, action);
  add_pause_command(app, action);
  add_resume_command(app, action);
  add_priority_command(app, action);
  add_workers_command(app, action);
  add_trust_command(app, action);
  add_convert_command(app, action);
  add_compare_command(app, action);
  try {
    app.parse(argc, argv);
    return action(interrupt);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  } catch (const std::exception& error) {  // out of memory, above all
    return report(kIncomplete, error.what());
  }
}
