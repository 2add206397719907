#include "command/server_option.h"

#include <iostream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/address.h"
#include "command/exit_code.h"
#include "net/channel.h"
#include "net/probe.h"
#include "net/status.h"

namespace tessera::client {

void define_server_option(options::Command& command, ServerOption& option) {
  command.group("Coordinator");
  command.add("--server", option.address, "the coordinator")
      .type_name("HOST:PORT")
      .from_environment("TESSERA_SERVER")
      .with_default();
  command.add("--tls", option.certificates, "a client's certificates")
      .type_name("DIR")
      .from_environment("TESSERA_TLS");
  command.add_flag("--allow-insecure", option.allow_insecure, "talk without encryption to another machine");
}

absl::StatusOr<std::unique_ptr<FarmClient>> connect(const ServerOption& option, bool quiet) {
  auto channel = net::make_channel(
      option.address, {.allow_insecure = option.allow_insecure, .certificates = option.certificates});
  if (!channel.ok()) return channel.status();
  FarmClientOptions options;
  options.address = option.address;
  if (!quiet)
    options.notice = [](const std::string& message) { std::cerr << "tessera: " << message << std::endl; };
  return std::make_unique<FarmClient>(*std::move(channel), std::move(options));
}

namespace {

/// Returns `status` with the reason why the call was never answered.
absl::Status explained(const absl::Status& status, const ServerOption& option) {
  constexpr std::chrono::milliseconds kPatience{1000};
  const absl::StatusOr<base::HostPort> address = base::parse_host_port(option.address);
  if (!address.ok() || !net::is_transient(status) || absl::IsCancelled(status)) return status;
  const bool encrypted = !option.certificates.empty();
  const auto unreachable = [&](const std::string& why) {
    return absl::UnavailableError(absl::StrCat(why, "\n  (", std::string{status.message()}, ")"));
  };
  switch (net::probe(*address, kPatience)) {
    case net::Speaks::kNobody:
      return absl::UnavailableError(absl::StrCat("no coordinator at ", option.address,
                                                 " (is tessera-server running? --server, TESSERA_SERVER)"));
    case net::Speaks::kTls:
      if (!encrypted) {
        return absl::UnavailableError(
            absl::StrCat(option.address, " speaks TLS: give --tls DIR (TESSERA_TLS)"));
      }
      return unreachable(absl::StrCat(option.address, " and the certificates in ", option.certificates,
                                      " do not go together, or it does not answer"));
    case net::Speaks::kPlain:
      if (encrypted) {
        return absl::UnavailableError(
            absl::StrCat(option.address, " does not speak TLS: leave --tls (TESSERA_TLS) away"));
      }
      break;
    case net::Speaks::kUnclear:
      return unreachable(
          absl::StrCat("what listens at ", option.address, " is no coordinator, or does not answer"));
  }
  return status;
}

}  // namespace

int report_farm_error(const absl::Status& status, const ServerOption& option) {
  return report_farm_error(explained(status, option));
}

}  // namespace tessera::client
