// A request to the web page, as text: "METHOD PATH", a line for each parameter ("?name=value") and header
// ("Name: value"), an empty line, the body. "JOB" stands for the id of the one job that there is.
#include <future>
#include <map>

#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "fuzz/target.h"
#include "service/coordinator_impl.h"
#include "service/farm/farm.h"
#include "service/farm/job_submission.h"
#include "service/rpc/blob_upload.h"
#include "service/web/event_stream.h"
#include "service/web/web_site.h"
#include "store/blobs/blob_store.h"
#include "unit/server/requests.h"

namespace tessera::fuzz {
namespace {

/// A coordinator in memory with one job of which nothing is rendered.
struct OneJob {
  std::shared_ptr<server::BlobStore> blobs = server::make_memory_blob_store();
  std::unique_ptr<server::Coordinator> coordinator;
  std::string job;

  OneJob() {
    v1::UploadRequest chunk;
    chunk.set_data("a scene");
    chunk.mutable_blob()->set_digest(wire::sha256_hex(chunk.data()));
    chunk.mutable_blob()->set_size_bytes(chunk.data().size());
    server::BlobUpload upload(*blobs);
    require(upload.take(chunk).ok() && upload.finish().ok(), "the scene is uploaded");
    server::CoordinatorOptions options;
    options.blobs = blobs;
    options.takes_messages = false;
    options.web = "127.0.0.1:0";
    coordinator = *server::Coordinator::start(options);
    v1::SubmitJobRequest request;
    request.set_request_id("1");
    *request.mutable_spec() = server::square_spec(chunk.data(), 32);
    std::promise<absl::StatusOr<std::string>> submitted;
    coordinator->farm().submission().submit(
        request, [&](absl::StatusOr<std::string> id) { submitted.set_value(std::move(id)); });
    const absl::StatusOr<std::string> id = submitted.get_future().get();
    require(id.ok(), "the job is taken");
    job = *id;
  }
};

server::HttpRequest read_request(std::string_view bytes, const std::string& job) {
  const std::string text = absl::StrReplaceAll(std::string(bytes), {{"JOB", job}});
  server::HttpRequest request;
  const std::size_t end = text.find("\n\n");
  if (end != std::string::npos) request.body = text.substr(end + 2);
  const std::map<std::string, std::string server::HttpRequest::*> headers = {
      {"Host", &server::HttpRequest::host},
      {"Origin", &server::HttpRequest::origin},
      {"Sec-Fetch-Site", &server::HttpRequest::fetch_site},
      {"Content-Type", &server::HttpRequest::content_type},
      {"Cookie", &server::HttpRequest::cookie},
      {"X-Tessera", &server::HttpRequest::marker}};
  for (const auto piece : absl::StrSplit(text.substr(0, end), '\n')) {
    const std::string line{piece};
    if (request.method.empty()) {
      const std::size_t space = line.find(' ');
      request.method = line.substr(0, space);
      if (space != std::string::npos) request.path = line.substr(space + 1);
    } else if (const std::size_t is = line.find('='); line.starts_with('?') && is != std::string::npos) {
      request.query[line.substr(1, is - 1)] = line.substr(is + 1);
    } else if (const std::size_t colon = line.find(": "); colon != std::string::npos) {
      if (const auto header = headers.find(line.substr(0, colon)); header != headers.end())
        request.*header->second = line.substr(colon + 2);
    }
  }
  return request;
}

bool accepts_web_request(std::string_view bytes) {
  static OneJob farm;
  const server::HttpRequest request = read_request(bytes, farm.job);
  const server::HttpAnswer answer = farm.coordinator->impl().site->answer(request);
  if (answer.events != nullptr) answer.events->abandon();
  require(answer.status >= 200 && answer.status < 500, "a request made the server fail");
  const bool may_change = request.method == "POST" && !request.marker.empty();
  if (answer.status == 200 && request.path.find("/api/") == 0 && !may_change)
    require(request.method == "GET" || request.method == "HEAD",
            "something else than GET and a marked POST was taken");
  if (request.host == "evil.example" || request.origin == "http://evil.example")
    require(answer.status == 403, "another site was answered");
  require(answer.body.size() < (1 << 20), "an answer is large");
  return answer.status == 200;
}

}  // namespace

const Target kWebRequest = {"web_request", accepts_web_request};

}  // namespace tessera::fuzz
