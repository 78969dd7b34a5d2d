// What a request is, in 64 hex digits: the same for the same fields.
#pragma once

#include <string>

#include "halfshade/v1/render.pb.h"

namespace halfshade {

// SHA-256 of the request's bytes. Another version of protobuf may order them otherwise; then digests differ, which
// costs a batch that is resumed a second render and nothing else.
std::string RequestDigest(const v1::RenderRequest& request);

}  // namespace halfshade
