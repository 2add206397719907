// The subcommands. Each function defines one with its options, and what is done when the command line names
// it.
#pragma once

#include "command/command_line.h"

namespace tessera::client {

void add_render_command(CommandLine& line);
void add_submit_command(CommandLine& line);
void add_estimate_command(CommandLine& line);
void add_jobs_command(CommandLine& line);
void add_job_command(CommandLine& line);
void add_watch_command(CommandLine& line);
void add_fetch_command(CommandLine& line);
void add_cancel_command(CommandLine& line);
void add_delete_command(CommandLine& line);
void add_retry_command(CommandLine& line);
void add_pause_command(CommandLine& line);
void add_resume_command(CommandLine& line);
void add_priority_command(CommandLine& line);
void add_workers_command(CommandLine& line);
void add_trust_command(CommandLine& line);
void add_token_command(CommandLine& line);
void add_expel_command(CommandLine& line);
void add_convert_command(CommandLine& line);
void add_compare_command(CommandLine& line);
void add_denoise_command(CommandLine& line);
void add_config_command(CommandLine& line);
void add_doctor_command(CommandLine& line);
void add_init_command(CommandLine& line);
void add_bench_command(CommandLine& line);
void add_radiosity_command(CommandLine& line);
void add_query_command(CommandLine& line);
void add_lens_command(CommandLine& line);
void add_measure_command(CommandLine& line);
void add_light_field_command(CommandLine& line);
void add_settings_command(CommandLine& line);

}  // namespace tessera::client
