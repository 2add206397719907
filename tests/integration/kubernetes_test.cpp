// deploy/kubernetes/tessera.yaml: its parts refer to one another, and its commands are ones that the programs
// take.
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "integration/farm_under_test.h"

namespace tessera::cluster {
namespace {

using Labels = std::map<std::string, std::string>;

Labels labels_of(const YAML::Node& node) { return node ? node.as<Labels>() : Labels{}; }

bool contains(const Labels& all, const Labels& some) {
  return !some.empty() && std::includes(all.begin(), all.end(), some.begin(), some.end());
}

/// Bytes of a quantity: "16Gi", "512Mi".
double bytes_of(const std::string& quantity) {
  std::size_t digits = 0;
  const double number = std::stod(quantity, &digits);
  const std::string unit = quantity.substr(digits);
  if (unit == "Gi") return number * (1ULL << 30);
  if (unit == "Mi") return number * (1ULL << 20);
  ADD_FAILURE() << "no unit that this test knows: " << quantity;
  return 0;
}

/// The value behind `option` on a command line; empty without.
std::string value_of(const std::vector<std::string>& command, const std::string& option) {
  const auto found = std::find(command.begin(), command.end(), option);
  return found == command.end() || found + 1 == command.end() ? "" : *(found + 1);
}

std::string port_of(const std::string& address) { return address.substr(address.rfind(':') + 1); }

/// Output of `PROGRAM --help`.
const std::string& help_of(const std::string& program) {
  static std::map<std::string, std::string> texts;
  const auto [text, added] = texts.emplace(program, "");
  if (added) {
    const std::map<std::string, std::string> paths{{"tessera-server", integration::server_program()},
                                                   {"tessera-worker", integration::worker_program()}};
    if (const auto path = paths.find(program); path != paths.end()) {
      text->second = support::run_program({path->second, "--help"}, integration::kPatience).out;
    }
  }
  return text->second;
}

class Kubernetes : public testing::Test {
 protected:
  void SetUp() override {
    for (const YAML::Node& document : YAML::LoadAllFromFile("deploy/kubernetes/tessera.yaml")) {
      documents_[document["kind"].as<std::string>()].push_back(document);
    }
  }

  /// StatefulSets and Deployments.
  std::vector<YAML::Node> workloads() {
    std::vector<YAML::Node> all = documents_["StatefulSet"];
    all.insert(all.end(), documents_["Deployment"].begin(), documents_["Deployment"].end());
    return all;
  }

  /// The one that these labels select; a failure of the test when it is not exactly one.
  YAML::Node selected(const YAML::Node& selector) {
    std::vector<YAML::Node> found;
    for (const YAML::Node& workload : workloads()) {
      if (contains(labels_of(workload["spec"]["template"]["metadata"]["labels"]), labels_of(selector))) {
        found.push_back(workload);
      }
    }
    EXPECT_EQ(found.size(), 1U) << selector;
    return found.empty() ? YAML::Node{} : found.front();
  }

  static YAML::Node container_of(const YAML::Node& workload) {
    const YAML::Node containers = workload["spec"]["template"]["spec"]["containers"];
    EXPECT_EQ(containers.size(), 1U);
    return containers[0];
  }

  /// Names and numbers of a container's ports.
  static std::set<std::string> ports_of(const YAML::Node& container) {
    std::set<std::string> ports;
    for (const YAML::Node& port : container["ports"]) {
      for (const char* const name : {"name", "containerPort"}) {
        EXPECT_TRUE(ports.insert(port[name].as<std::string>()).second) << port << " twice";
      }
    }
    return ports;
  }

  std::map<std::string, std::vector<YAML::Node>> documents_;
};

TEST_F(Kubernetes, PartsReferToOneAnother) {
  ASSERT_EQ(workloads().size(), 2U);
  for (const YAML::Node& workload : workloads()) {
    const YAML::Node spec = workload["spec"], pod = spec["template"]["spec"],
                     container = container_of(workload);
    EXPECT_TRUE(contains(labels_of(spec["template"]["metadata"]["labels"]),
                         labels_of(spec["selector"]["matchLabels"])));
    EXPECT_TRUE(pod["securityContext"]["runAsNonRoot"].as<bool>());

    std::set<std::string> volumes;
    for (const YAML::Node& volume : pod["volumes"]) volumes.insert(volume["name"].as<std::string>());
    for (const YAML::Node& claim : spec["volumeClaimTemplates"]) {
      volumes.insert(claim["metadata"]["name"].as<std::string>());
    }
    std::set<std::string> mounted;
    for (const YAML::Node& mount : container["volumeMounts"]) mounted.insert(mount["name"].as<std::string>());
    EXPECT_EQ(mounted, volumes) << container["name"];
  }
  for (const YAML::Node& service : documents_["Service"]) {
    const std::set<std::string> ports = ports_of(container_of(selected(service["spec"]["selector"])));
    for (const YAML::Node& port : service["spec"]["ports"]) {
      EXPECT_TRUE(ports.contains(port["targetPort"].as<std::string>())) << port;
    }
  }
  for (const YAML::Node& policy : documents_["NetworkPolicy"]) {
    const std::set<std::string> ports =
        ports_of(container_of(selected(policy["spec"]["podSelector"]["matchLabels"])));
    for (const YAML::Node& rule : policy["spec"]["ingress"]) {
      for (const YAML::Node& port : rule["ports"])
        EXPECT_TRUE(ports.contains(port["port"].as<std::string>())) << port;
    }
  }
}

TEST_F(Kubernetes, ProgramsAreProbedAndTakeTheirCommands) {
  for (const YAML::Node& workload : workloads()) {
    const YAML::Node container = container_of(workload);
    const auto command = container["command"].as<std::vector<std::string>>();
    const std::string& help = help_of(command.front());
    ASSERT_FALSE(help.empty()) << command.front() << " is no program of Tessera's";
    for (const std::string& word : command) {
      if (!word.starts_with("--")) continue;
      EXPECT_NE(help.find(word + " "), std::string::npos) << command.front() << " has no " << word;
    }
    const std::set<std::string> ports = ports_of(container);
    for (const char* const listening : {"--listen", "--health", "--metrics"}) {
      const std::string address = value_of(command, listening);
      if (address.empty()) continue;
      EXPECT_TRUE(ports.contains(port_of(address))) << listening << " " << address;
    }
    ASSERT_TRUE(container["livenessProbe"]);
    for (const char* const name : {"startupProbe", "readinessProbe", "livenessProbe"}) {
      const YAML::Node probe = container[name];
      if (!probe) continue;
      if (probe["grpc"]) {
        EXPECT_EQ(probe["grpc"]["port"].as<std::string>(), port_of(value_of(command, "--health")));
      }
      if (probe["httpGet"]) {
        EXPECT_EQ(probe["httpGet"]["path"].as<std::string>(), "/metrics");
        EXPECT_TRUE(ports.contains(probe["httpGet"]["port"].as<std::string>()));
      }
      EXPECT_TRUE(probe["grpc"] || probe["httpGet"]) << name;
    }
  }
}

TEST_F(Kubernetes, WorkersCallTheServiceAndStayWithinTheirLimits) {
  const YAML::Node worker = container_of(documents_["Deployment"].at(0));
  const auto command = worker["command"].as<std::vector<std::string>>();
  const YAML::Node service = documents_["Service"].at(0);
  EXPECT_EQ(value_of(command, "--server"), service["metadata"]["name"].as<std::string>() + ":" +
                                               service["spec"]["ports"][0]["port"].as<std::string>());
  const YAML::Node limits = worker["resources"]["limits"];
  EXPECT_EQ(value_of(command, "--threads"), limits["cpu"].as<std::string>());
  // Stacks, code and the kernel's own do not count for --memory-limit (GB), but for Kubernetes: a twentieth
  // is left to them.
  EXPECT_LE(std::stod(value_of(command, "--memory-limit")) * 1e9,
            0.95 * bytes_of(limits["memory"].as<std::string>()));
}

}  // namespace
}  // namespace tessera::cluster
