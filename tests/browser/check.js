// SPDX-License-Identifier: MIT
// Runs inside a copy of the page: what does a person with a screen this wide
// see? Tells the frame around it, one line for each thing that is wrong.
const wrong = []
const page = document.documentElement
if (page.scrollWidth > innerWidth)
  wrong.push(`the page is ${page.scrollWidth} wide on ${innerWidth}`)

const charts = [...document.querySelectorAll('svg.chart')]
for (const chart of charts) {
  const name = chart.getAttribute('aria-label')
  const drawn = [...chart.querySelectorAll('circle, rect')].filter(e => e.getBBox().width > 0)
  if (drawn.length === 0)
    wrong.push(`'${name}' has no data`)
  const frame = chart.getBoundingClientRect()
  for (const part of chart.querySelectorAll('circle, rect, text, polyline, line')) {
    const box = part.getBoundingClientRect()
    if (box.left < frame.left - 1 || box.right > frame.right + 1 ||
        box.top < frame.top - 1 || box.bottom > frame.bottom + 1)
      wrong.push(`'${name}': ${part.tagName} '${part.textContent}' lies outside`)
  }
}
if (charts.length === 0)
  wrong.push('there is no chart')
parent.postMessage(`${innerWidth} wide: ${wrong.length ? wrong.join('; ') : charts.length + ' charts are right'}`, '*')
