#!/bin/sh
set -e
$solution
