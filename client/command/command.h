// The subcommands. Each add_ function defines one with its options; when the command line names it, it puts what is to
// be done into `action`.
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace tessera::client {

class Interrupt;

/// Does the work and returns the exit code.
using Action = std::function<int(Interrupt&)>;

void add_render_command(CLI::App& app, Action& action);
void add_submit_command(CLI::App& app, Action& action);
void add_jobs_command(CLI::App& app, Action& action);
void add_job_command(CLI::App& app, Action& action);
void add_watch_command(CLI::App& app, Action& action);
void add_fetch_command(CLI::App& app, Action& action);
void add_cancel_command(CLI::App& app, Action& action);
void add_retry_command(CLI::App& app, Action& action);
void add_pause_command(CLI::App& app, Action& action);
void add_resume_command(CLI::App& app, Action& action);
void add_priority_command(CLI::App& app, Action& action);
void add_workers_command(CLI::App& app, Action& action);
void add_trust_command(CLI::App& app, Action& action);
void add_convert_command(CLI::App& app, Action& action);
void add_compare_command(CLI::App& app, Action& action);

}  // namespace tessera::client
