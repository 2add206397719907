// An upload stream: each part is one chunk. Digests of one letter stand for what they would be if the client
// told the truth, so that uploads can succeed.
#include "fuzz/mutate_message.h"
#include "fuzz/target.h"
#include "service/rpc/blob_upload.h"
#include "wire/digest.h"

namespace tessera::fuzz {
namespace {

bool accepts_upload(std::string_view bytes) {
  std::vector<v1::UploadRequest> chunks;
  std::string contents;
  for (const std::string& part : split_parts(bytes)) {
    if (!chunks.emplace_back().ParseFromString(part)) return false;
    contents += chunks.back().data();
  }
  if (chunks.empty()) return false;
  const std::string truth = wire::sha256_hex(contents);
  for (v1::UploadRequest& chunk : chunks) {
    if (chunk.blob().digest().size() == 1) chunk.mutable_blob()->set_digest(truth);
  }

  const std::unique_ptr<server::BlobStore> blobs = server::make_memory_blob_store();
  absl::Status status;
  // The stream breaks after half of the chunks, and another goes on; then the whole comes once more.
  for (const std::size_t end : {chunks.size() / 2, chunks.size()}) {
    server::BlobUpload upload(*blobs);
    for (std::size_t i = 0; i < end && status.ok() && upload.wants_more(); ++i)
      status = upload.take(chunks[i]);
    status.Update(upload.finish());
    require(status.ok() || !status.message().empty(), "an error without a message");
    if (end < chunks.size()) status = absl::OkStatus();
  }
  const std::string& digest = chunks.front().blob().digest();
  if (!wire::is_digest(digest)) return false;
  const auto reader = blobs->read(digest);
  require(!status.ok() || reader.ok(), "an upload that succeeded left no blob");
  if (reader.ok()) {
    const auto stored = (*reader)->read(0, contents.size() + 1);
    require(stored.ok() && wire::sha256_hex(*stored) == digest, "a blob does not have its digest");
  }
  return status.ok();
}

std::string mutate_upload(std::string bytes, std::mt19937& random) {
  std::vector<std::string> parts = split_parts(bytes);
  if (parts.empty() || random() % 8 == 0) return mutate_bytes(std::move(bytes), random);
  std::string& part = parts[random() % parts.size()];
  v1::UploadRequest chunk;
  if (!chunk.ParseFromString(part)) return mutate_bytes(std::move(bytes), random);
  mutate_message(chunk, random);
  part = chunk.SerializeAsString();
  if (random() % 8 == 0) parts.push_back(parts[random() % parts.size()]);
  return join_parts(parts);
}

}  // namespace

const Target kUpload = {"upload", accepts_upload, mutate_upload};

}  // namespace tessera::fuzz
