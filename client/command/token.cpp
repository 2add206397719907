// tessera token
#include <charconv>
#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct TokenOptions {
  ServerOption server;
  std::chrono::seconds lifetime{std::chrono::hours{1}};
  std::uint32_t uses = 1;
};

/// "90s", "30m", "1h", "2d".
absl::Status read_lifetime(const std::string& text, std::chrono::seconds& lifetime) {
  std::int32_t number = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string unit{rest, text.data() + text.size()};
  std::int64_t seconds = 0;
  if (unit == "s") seconds = 1;
  if (unit == "m") seconds = 60;
  if (unit == "h") seconds = 3600;
  if (unit == "d") seconds = 86400;
  if (error != std::errc() || seconds == 0 || number <= 0) {
    return absl::InvalidArgumentError("expected a time such as 30m, 1h or 2d");
  }
  lifetime = std::chrono::seconds{number * seconds};
  return absl::OkStatus();
}

int run(const TokenOptions& options, Interrupt& interrupt) {
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  const absl::StatusOr<std::string> token =
      (*farm)->make_join_token(options.lifetime, options.uses, interrupt.token());
  if (!token.ok()) return report_farm_error(token.status(), options.server);
  std::cout << *token << '\n';
  return kDone;
}

}  // namespace

void add_token_command(CommandLine& line) {
  auto options = std::make_shared<TokenOptions>();
  Command command =
      line.add_command("token", "Print a token with which workers join the farm (tessera-worker --join)");
  command
      .add_read_by(
          "--for", [options](const std::string& text) { return read_lifetime(text, options->lifetime); },
          "how long it is accepted: 30m, 1h, 2d (default: 1h)")
      .type_name("TIME");
  command.add("--uses", options->uses, "how many workers may join with it").with_default();
  define_server_option(command, options->server);
  command.example("tessera token --for 2h --uses 20 --tls ~/farm-tls/admin");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
