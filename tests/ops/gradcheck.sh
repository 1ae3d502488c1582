#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Every op's gradient, as `palmar gradcheck --all` checks it.
exec ./palmar-gradcheck --all
