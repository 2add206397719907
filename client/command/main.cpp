// tessera: renders scenes here or on a farm.
#include "command/command.h"
#include "command/interrupt.h"
#include "wire/version.h"

int main(int argc, char** argv) {
  using namespace tessera::client;
  Interrupt interrupt;
  CommandLine line{
      "tessera", "Renders scenes, in this process or on a farm of workers.",
      "Exit codes: 0 done, 2 usage, 3 bad scene, 4 cannot reach or not allowed, 5 job failed, 6 incomplete, "
      "7 image with marked holes (tessera retry), 130 interrupted.",
      tessera::wire::build_version()};
  for (const auto add :
       {add_render_command, add_submit_command, add_jobs_command, add_job_command, add_watch_command, add_fetch_command,
        add_cancel_command, add_retry_command, add_pause_command, add_resume_command, add_priority_command,
        add_workers_command, add_trust_command, add_token_command, add_expel_command, add_convert_command,
        add_compare_command, add_bench_command}) {
    add(line);
  }
  return line.run(argc, argv, interrupt);
}
