#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Makes configure. Needed once after a clone, and after configure.ac changed.
set -e
cd "$(dirname "$0")"
autoreconf --install --warnings=all
