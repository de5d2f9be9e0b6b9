#!/usr/bin/env python3
"""Makes the pictures of the docs anew, from reports as the command writes them: docs/images/make.py ELASTOGEO.

report.png is a screenshot; the question-*.svg are charts cut out of reports, in the colours of light paper.
"""

import os
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "tests", "browser"))

from chromium import Browser

# Bundled campaign, picture, and the axis whose row of charts is shown above the waterfall.
QUESTIONS = [("kr270-no-compensator", "question-compensator.svg", "q2, deg"),
             ("kr270-rigid-joint-1", "question-joint-1.svg", "q2, deg"),
             ("ir663-axial-screws", "question-screws.svg", "stroke8, mm")]
# Charts as text, with the page's colours put in.
CHARTS = """(axis) => { const style = getComputedStyle(document.documentElement);
  const row = [...document.querySelectorAll('#patterns .panels')].find((p) => p.dataset.against === axis);
  return [...row.querySelectorAll('svg.chart'), document.querySelector('#waterfall svg.chart')].map((svg) =>
    svg.outerHTML.replaceAll(/var\\((--[a-z]+)\\)/g, (_, name) => style.getPropertyValue(name).trim())); }"""


def report(program, campaign, folder):
    page = os.path.join(folder, campaign + ".html")
    subprocess.run([program, "report", campaign, "--output", page], check=True, stdout=subprocess.DEVNULL)
    return page


def placed(chart, x, y, width):
    """A chart at a place of a drawing, in its own size where no width is given."""
    box = [float(n) for n in re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', chart).groups()]
    width = width or min(box[0], 990)
    height = width * box[1] / box[0]
    inside = re.sub(r'^<svg[^>]*viewBox="([^"]*)"[^>]*?(aria-label="[^"]*")[^>]*?>',
                    rf'<svg x="{x}" y="{y}" width="{width}" height="{height:.0f}" font-family="sans-serif" viewBox="\1" role="img" \2 fill="#1d2433">',
                    chart, count=1)
    return inside, height


def main():
    program = os.path.abspath(sys.argv[1])
    browser = Browser()
    try:
        with tempfile.TemporaryDirectory() as folder:
            for campaign, name, axis in QUESTIONS:
                browser.open(report(program, campaign, folder))
                charts = browser.evaluate(f"({CHARTS})('{axis}')")
                parts, top = [], 0
                for k, chart in enumerate(charts[:-1]):
                    part, height = placed(chart, 330 * k, 0, 330)
                    parts.append(part)
                    top = max(top, height)
                part, height = placed(charts[-1], 0, top + 10, None)
                total = round(top + 10 + height)
                with open(os.path.join(HERE, name), "w") as file:
                    file.write(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 990 {total}" width="990" height="{total}">'
                               f'<rect width="990" height="{total}" fill="#ffffff"/>{"".join(parts)}{part}</svg>\n')
            browser.open(report(program, "kr270-no-compensator", folder), 1180, 1500)
            browser.picture(os.path.join(HERE, "report.png"), whole=False)
    finally:
        browser.close()


main()
