# SPDX-License-Identifier: Apache-2.0
target_sources(uwv_geometry PRIVATE
)
