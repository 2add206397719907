// tessera expel NAME
#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct ExpelOptions {
  ServerOption server;
  std::string name;
  std::string role = "worker";
  bool undo = false;
  bool unseen = false;
};

int run(const ExpelOptions& options, Interrupt& interrupt) {
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  v1::ExpelRequest request;
  request.set_role(options.role);
  request.set_name(options.name);
  request.set_undo(options.undo);
  request.set_unseen(options.unseen);
  const absl::StatusOr<v1::ExpelResponse> response = (*farm)->expel(request, interrupt.token());
  if (!response.ok()) return report_farm_error(response.status(), options.server);
  if (options.undo) {
    std::cout << options.role << " " << options.name << " may come back\n";
    return kDone;
  }
  std::cout << options.role << " " << options.name << " is expelled";
  if (options.role == "worker") {
    std::cout << ": " << response->workers() << " at work, " << response->join_tokens()
              << " join tokens called back";
  }
  std::cout << '\n';
  return kDone;
}

}  // namespace

void add_expel_command(CommandLine& line) {
  auto options = std::make_shared<ExpelOptions>();
  Command command = line.add_command("expel", "Expel a member: revoke its certificates");
  command.add("NAME", options->name, "the name in the certificate (tessera workers)").required();
  command.add("--role", options->role, "what the certificate is for")
      .type_name("ROLE")
      .one_of({"worker", "client", "admin"})
      .with_default();
  command.add_flag("--undo", options->undo, "accept the certificates again");
  command.add_flag("--unseen", options->unseen, "also when nobody of that name ever called the coordinator");
  define_server_option(command, options->server);
  command.example("tessera expel render7 --tls ~/farm-tls/admin");
  command.example("tessera expel --role client alice --tls ~/farm-tls/admin");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
