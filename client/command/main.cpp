// tessera: renders scenes here or on a farm.
#include "base/freed_memory.h"
#include "command/command.h"
#include "command/interrupt.h"
#include "net/grpc_log.h"

int main(int argc, char** argv) {
  using namespace tessera::client;
  tessera::net::mute_grpc();
  tessera::base::keep_freed_memory();
  Interrupt interrupt;
  CommandLine line{interrupt};
  line.group("Rendering");
  add_render_command(line);
  add_submit_command(line);
  add_estimate_command(line);
  add_radiosity_command(line);
  add_fetch_command(line);
  add_settings_command(line);
  line.group("Jobs on the farm");
  for (const auto add :
       {add_jobs_command, add_job_command, add_watch_command, add_cancel_command, add_delete_command,
        add_retry_command, add_pause_command, add_resume_command, add_priority_command}) {
    add(line);
  }
  line.group("Administration");
  for (const auto add : {add_workers_command, add_trust_command, add_token_command, add_expel_command})
    add(line);
  line.group("Files and measurement");
  for (const auto add : {add_convert_command, add_denoise_command, add_compare_command, add_bench_command,
                         add_query_command, add_lens_command, add_measure_command, add_light_field_command}) {
    add(line);
  }
  line.group("Setting up");
  for (const auto add : {add_init_command, add_config_command, add_doctor_command}) add(line);
  return line.run(argc, argv);
}
